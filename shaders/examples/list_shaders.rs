//! Lists the stages of all passes with the size of their SPIR-V.

use antumbra_shaders::{PASSES, PREDICATE_COUNTS, PREDICATE_INSTANCES, SUM_QUERIES};

fn main() {
    for shader in PASSES.iter().chain(&[PREDICATE_COUNTS, PREDICATE_INSTANCES, SUM_QUERIES]) {
        println!("{:24} {:6} bytes", shader.name, shader.spirv.len());
    }
}
