//! The shaders: SPIR-V embedded beside its GLSL, or compiled from a folder while developing.

use std::path::Path;

use gpu::Spirv;

use crate::error::Error;

/// One shader as it is built into the engine.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    /// The GLSL file's name.
    pub name: &'static str,
    /// The SPIR-V committed beside it.
    pub spirv: &'static [u8],
}

macro_rules! shader {
    ($name:literal) => {
        Shader { name: $name, spirv: include_bytes!(concat!("../../../shaders/", $name, ".spv")) }
    };
}

/// Every shader of the passes.
pub const SHADERS: [Shader; 26] = [
    shader!("opaque.vert"),
    shader!("opaque.frag"),
    shader!("proxy.vert"),
    shader!("proxy.frag"),
    shader!("leaf_box.vert"),
    shader!("leaf_box.frag"),
    shader!("overlay.vert"),
    shader!("overlay.frag"),
    shader!("wires.frag"),
    shader!("flat.vert"),
    shader!("flat.frag"),
    shader!("seen.vert"),
    shader!("seen.frag"),
    shader!("sky.vert"),
    shader!("sky.frag"),
    shader!("depth_grid.comp"),
    shader!("compute_test.comp"),
    shader!("pyramid_build.comp"),
    shader!("pyramid_first.comp"),
    shader!("pyramid_second.comp"),
    shader!("scatter.comp"),
    shader!("deform.comp"),
    shader!("surface.vert"),
    shader!("surface.frag"),
    shader!("surface_depth.vert"),
    shader!("surface_depth.frag"),
];

/// The shaders a renderer is built from.
#[derive(Debug, Clone)]
pub struct ShaderSet {
    loaded: Vec<Spirv>,
}

impl ShaderSet {
    /// The embedded ones.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn embedded() -> Result<Self, Error> {
        let load = |shader: &Shader| Spirv::from_bytes(shader.name, shader.spirv);
        Ok(Self { loaded: SHADERS.iter().map(load).collect::<Result<_, _>>()? })
    }

    /// All of them compiled from the GLSL in `folder`.
    ///
    /// # Errors
    /// The first shader that does not compile, with file and line; [`Error::NoShaderCompiler`] in
    /// a build without the feature `shader-compiler`.
    #[cfg(feature = "shader-compiler")]
    pub fn compiled_from(folder: &Path) -> Result<Self, Error> {
        let compile = |shader: &Shader| gpu::compile(&folder.join(shader.name));
        Ok(Self { loaded: SHADERS.iter().map(compile).collect::<Result<_, _>>()? })
    }

    /// All of them compiled from the GLSL in `folder`.
    ///
    /// # Errors
    /// Always [`Error::NoShaderCompiler`]: this build lacks the feature `shader-compiler`.
    #[cfg(not(feature = "shader-compiler"))]
    pub fn compiled_from(folder: &Path) -> Result<Self, Error> {
        Err(Error::NoShaderCompiler(folder.display().to_string()))
    }

    /// Returns the set for a scene with sprites: its vertex shaders place them
    /// (`SPRITES` of `sprites.glsl`), which costs every vertex of the scene.
    #[must_use]
    pub(crate) fn with_sprites(mut self) -> Self {
        const SPRITES: (u32, u32) = (13, 1);
        for shader in self.loaded.iter_mut().filter(|shader| shader.name.ends_with(".vert")) {
            *shader = shader.specialised(&[SPRITES]);
        }
        self
    }

    pub(crate) fn find(&self, name: &str) -> Result<&Spirv, Error> {
        let found = self.loaded.iter().find(|spirv| spirv.name == name);
        Ok(found.ok_or_else(|| gpu::Error::NotSpirv { name: name.to_owned() })?)
    }
}
