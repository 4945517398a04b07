//! Compiles every GLSL file of the shader folder and writes SPIR-V and a hash next to it.

use std::path::Path;

use shaders::sources;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    for name in sources::stages(&folder)? {
        let spirv = antumbra_gpu::compile(&folder.join(&name))?;
        std::fs::write(folder.join(format!("{name}.spv")), spirv.to_bytes())?;
        println!("{name}");
    }
    std::fs::write(folder.join("sources.sha256"), sources::hashes(&folder)?)?;
    Ok(())
}
