// The pointer pass: a fragment as near as the finished image owns the pixel under the pointer.
#version 460
#extension GL_KHR_memory_scope_semantics : require

layout(early_fragment_tests) in;

layout(location = 0) flat in uint leaf;

// The complement of the leaf's number, so that 0 is none and the first leaf wins where several are
// equally near; and the bits of the depth, which is not negative.
layout(std430, binding = 1) buffer Pointed { uint leaf_complement; uint depth_bits; };

void main() {
    atomicMax(leaf_complement, ~leaf, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
    atomicMax(depth_bits, floatBitsToUint(gl_FragCoord.z), gl_ScopeDevice, gl_StorageSemanticsNone,
              gl_SemanticsRelaxed);
}
