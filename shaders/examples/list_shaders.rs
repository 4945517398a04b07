//! Lists the stages of all passes with the size of their SPIR-V.

use antumbra_shaders::{
    FARTHEST_DEPTHS, PASSES, PREDICATE_COUNTS, PREDICATE_INSTANCES, SUM_QUERIES,
};

fn main() {
    let beside = [PREDICATE_COUNTS, PREDICATE_INSTANCES, SUM_QUERIES, FARTHEST_DEPTHS];
    for shader in PASSES.iter().chain(&beside) {
        println!("{:24} {:6} bytes", shader.name, shader.spirv.len());
    }
}
