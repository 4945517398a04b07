//! The shaders of a renderer: embedded SPIR-V, or GLSL compiled from a folder during development.

use std::path::Path;

use gpu::{SpecializationConstant, Spirv};
use shaders::{PASSES, Shader};

use crate::error::Error;

/// The shaders that a renderer is built from.
#[derive(Debug, Clone)]
pub struct ShaderSet {
    loaded: Vec<Spirv>,
    section: SectionShaders,
}

/// A choice of the shaders that objects are drawn with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SectionShaders {
    /// Shaders that draw objects whole.
    #[default]
    Whole,
    /// Shaders that cut objects by section planes, with two more storage buffers after the others.
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

    /// Compiles all shaders from the GLSL files in `folder`.
    ///
    /// # Errors
    /// The first shader that does not compile, with file and line; [`Error::NoShaderCompiler`] in
    /// a build without the feature `shader-compiler`.
    #[cfg(feature = "shader-compiler")]
    pub fn compiled_from(folder: &Path) -> Result<Self, Error> {
        let compile = |shader: &Shader| gpu::compile(&folder.join(shader.name));
        Ok(Self::of(PASSES.iter().map(compile).collect::<Result<_, _>>()?))
    }

    /// Fails, since this build cannot compile the GLSL files in `folder`.
    ///
    /// # Errors
    /// Always [`Error::NoShaderCompiler`]: this build lacks the feature `shader-compiler`.
    #[cfg(not(feature = "shader-compiler"))]
    pub fn compiled_from(folder: &Path) -> Result<Self, Error> {
        Err(Error::NoShaderCompiler(folder.display().to_string()))
    }

    /// Returns this set with vertex shaders that place sprites (`SPRITES` of `sprites.glsl`). They
    /// cost time for every vertex of the scene.
    #[must_use]
    pub fn with_sprites(mut self) -> Self {
        const SPRITES: SpecializationConstant = SpecializationConstant { id: 13, value: 1 };
        for shader in self.loaded.iter_mut().filter(|shader| shader.name.ends_with(".vert")) {
            *shader = shader.specialised(&[SPRITES]);
        }
        self
    }

    fn of(loaded: Vec<Spirv>) -> Self {
        Self { loaded, section: SectionShaders::Whole }
    }

    /// Returns this set with another choice of the shaders of objects: cut by section planes, or
    /// whole.
    #[must_use]
    pub fn with_section(self, section: SectionShaders) -> Self {
        Self { section, ..self }
    }

    /// Returns the choice of the shaders of objects.
    pub fn section(&self) -> SectionShaders {
        self.section
    }

    /// Returns the shader of a pass of objects, by the name of the pass and the end of the file
    /// name: cut by section planes or whole, as chosen.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn find_of_objects(&self, pass: &str, end: &str) -> Result<&Spirv, Error> {
        match self.section {
            SectionShaders::Whole => self.find(&format!("{pass}.{end}")),
            SectionShaders::Cut => self.find(&format!("{pass}_section.{end}")),
        }
    }

    /// Returns the shader with this file name.
    ///
    /// # Errors
    /// None, unless the build itself is broken.
    pub fn find(&self, name: &str) -> Result<&Spirv, Error> {
        let found = self.loaded.iter().find(|spirv| spirv.name == name);
        Ok(found.ok_or_else(|| gpu::Error::NotSpirv { name: name.to_owned() })?)
    }
}
