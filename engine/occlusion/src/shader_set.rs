//! The shaders of a renderer: the embedded SPIR-V, or GLSL compiled from a folder while developing.

use std::path::Path;

use gpu::Spirv;
use shaders::{PASSES, Shader};

use crate::error::Error;

/// The shaders a renderer is built from.
#[derive(Debug, Clone)]
pub struct ShaderSet {
    loaded: Vec<Spirv>,
    section: SectionShaders,
}

/// The shaders that objects are drawn with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SectionShaders {
    /// Those that draw objects whole.
    #[default]
    Whole,
    /// Those that section planes cut, with two more storage buffers behind the others.
    Cut,
}

impl ShaderSet {
    /// Returns the embedded shaders.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn embedded() -> Result<Self, Error> {
        let load = |shader: &Shader| Spirv::from_bytes(shader.name, shader.spirv);
        Ok(Self::of(PASSES.iter().map(load).collect::<Result<_, _>>()?))
    }

    /// Compiles all of them from the GLSL in `folder`.
    ///
    /// # Errors
    /// The first shader that does not compile, with file and line; [`Error::NoShaderCompiler`] in
    /// a build without the feature `shader-compiler`.
    #[cfg(feature = "shader-compiler")]
    pub fn compiled_from(folder: &Path) -> Result<Self, Error> {
        let compile = |shader: &Shader| gpu::compile(&folder.join(shader.name));
        Ok(Self::of(PASSES.iter().map(compile).collect::<Result<_, _>>()?))
    }

    /// Fails to compile the GLSL in `folder`.
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
    pub fn with_sprites(mut self) -> Self {
        const SPRITES: (u32, u32) = (13, 1);
        for shader in self.loaded.iter_mut().filter(|shader| shader.name.ends_with(".vert")) {
            *shader = shader.specialised(&[SPRITES]);
        }
        self
    }

    fn of(loaded: Vec<Spirv>) -> Self {
        Self { loaded, section: SectionShaders::Whole }
    }

    /// Returns the same set, of which passes take the shaders of objects that are cut by section
    /// planes, or whole.
    #[must_use]
    pub fn with_section(self, section: SectionShaders) -> Self {
        Self { section, ..self }
    }

    /// Returns the shaders of objects that passes take.
    pub fn section(&self) -> SectionShaders {
        self.section
    }

    /// Returns the shader of a pass of objects, by the name of the pass and the end of its file's
    /// name: cut by section planes or whole.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn find_of_objects(&self, pass: &str, end: &str) -> Result<&Spirv, Error> {
        match self.section {
            SectionShaders::Whole => self.find(&format!("{pass}.{end}")),
            SectionShaders::Cut => self.find(&format!("{pass}_section.{end}")),
        }
    }

    /// Returns the shader of this file name.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn find(&self, name: &str) -> Result<&Spirv, Error> {
        let found = self.loaded.iter().find(|spirv| spirv.name == name);
        Ok(found.ok_or_else(|| gpu::Error::NotSpirv { name: name.to_owned() })?)
    }
}
