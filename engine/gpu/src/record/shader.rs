//! Shaders: embedded SPIR-V and, with the feature `shader-compiler`, GLSL compiled at run time.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::{Called, Error};

/// A compiled shader with entry point `main`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spirv {
    /// The name of the shader, which debuggers show.
    pub name: String,
    code: Vec<u32>,
    /// The values of specialisation constants, by id; other constants keep their defaults.
    constants: Vec<SpecializationConstant>,
}

const SPIRV_MAGIC: u32 = 0x0723_0203;

/// The value of a specialisation constant of 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpecializationConstant {
    /// The id of the constant in the shader.
    pub id: u32,
    /// The value.
    pub value: u32,
}

impl Spirv {
    /// Creates a shader from SPIR-V bytes, in the machine's byte order.
    ///
    /// # Errors
    /// [`Error::NotSpirv`] for bytes that are not SPIR-V.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let code: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|byte| u32::from_le_bytes([byte[0], byte[1], byte[2], byte[3]]))
            .collect();
        let whole = bytes.len().is_multiple_of(4);
        if !whole || code.first() != Some(&SPIRV_MAGIC) || code.len() < 5 {
            return Err(Error::NotSpirv { name: name.to_owned() });
        }
        Ok(Self { name: name.to_owned(), code, constants: Vec::new() })
    }

    /// Returns the bytes of the shader, little-endian, as they are stored next to the GLSL.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.code.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    /// Returns the shader with additional values for specialisation constants of 32 bits, each id
    /// once. Pipelines are compiled with these values, so code that they disable costs nothing. An
    /// id that the shader does not have is ignored.
    #[must_use]
    pub fn specialised(&self, constants: &[SpecializationConstant]) -> Self {
        Self { constants: [&self.constants, constants].concat(), ..self.clone() }
    }

    /// Calls `make` with the module and its constants, and then destroys the module, because
    /// pipelines do not need it after their creation.
    pub(crate) fn with_stage<R>(
        &self,
        device: &Device,
        stage: vk::ShaderStageFlags,
        make: impl FnOnce(vk::PipelineShaderStageCreateInfo<'_>) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let values: Vec<u32> = self.constants.iter().map(|constant| constant.value).collect();
        let entry = |(place, constant): (usize, &SpecializationConstant)| {
            let size = size_of::<u32>();
            let offset = (place * size) as u32;
            vk::SpecializationMapEntry { constant_id: constant.id, offset, size }
        };
        let entries: Vec<_> = self.constants.iter().enumerate().map(entry).collect();
        let constants = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(bytemuck::cast_slice(&values));
        let info = vk::ShaderModuleCreateInfo::default().code(&self.code);
        // SAFETY: the code starts like SPIR-V; the validation layer checks the rest.
        let module = unsafe { device.raw().create_shader_module(&info, device.callbacks()) }
            .called("vkCreateShaderModule")?;
        device.name(module, &self.name);
        let info = vk::PipelineShaderStageCreateInfo::default()
            .stage(stage)
            .module(module)
            .name(c"main")
            .specialization_info(&constants);
        let made = make(info);
        // SAFETY: no pipeline refers to the module after its creation.
        unsafe { device.raw().destroy_shader_module(module, device.callbacks()) };
        made
    }
}

/// Compiles the GLSL file `path`. Its extension (`.vert`, `.tesc`, `.tese`, `.geom`, `.frag`,
/// `.comp`) determines the stage, and `#include "name"` refers to a file in the same folder.
///
/// # Errors
/// [`Error::ShaderCompile`] with the file and line of every mistake.
#[cfg(feature = "shader-compiler")]
pub fn compile(path: &std::path::Path) -> Result<Spirv, Error> {
    let name = path.display().to_string();
    let refuse = |log: String| Error::ShaderCompile { name: name.clone(), log };
    let stage = match path.extension().and_then(|extension| extension.to_str()) {
        Some("vert") => shaderc::ShaderKind::Vertex,
        Some("tesc") => shaderc::ShaderKind::TessControl,
        Some("tese") => shaderc::ShaderKind::TessEvaluation,
        Some("geom") => shaderc::ShaderKind::Geometry,
        Some("frag") => shaderc::ShaderKind::Fragment,
        Some("comp") => shaderc::ShaderKind::Compute,
        _ => {
            let endings = ".vert, .tesc, .tese, .geom, .frag or .comp";
            return Err(refuse(format!("its name must end in {endings}")));
        }
    };
    let source = std::fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
    let compiler = shaderc::Compiler::new().map_err(|error| refuse(error.to_string()))?;
    let mut options = shaderc::CompileOptions::new().map_err(|error| refuse(error.to_string()))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    let folder = path.parent().map(std::path::Path::to_owned).unwrap_or_default();
    options.set_include_callback(move |wanted, _, from, _| {
        let included = folder.join(wanted);
        let content = std::fs::read_to_string(&included)
            .map_err(|error| format!("{wanted}, included from {from}: {error}"))?;
        let resolved_name = included.display().to_string();
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    let compiled = compiler
        .compile_into_spirv(&source, stage, &name, "main", Some(&options))
        .map_err(|error| refuse(error.to_string()))?;
    let file_name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    Spirv::from_bytes(&file_name.unwrap_or(name), compiled.as_binary_u8())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_spirv_is_refused() {
        for bytes in [&b""[..], b"void main() {}", &[3, 2, 35, 7], &[0; 40]] {
            assert!(matches!(Spirv::from_bytes("x", bytes), Err(Error::NotSpirv { .. })));
        }
        let mut bytes = SPIRV_MAGIC.to_le_bytes().to_vec();
        bytes.extend([0; 16]);
        let spirv = Spirv::from_bytes("x", &bytes).unwrap();
        assert_eq!(spirv.to_bytes(), bytes);
    }
}
