// The object under a pointer. A shader that includes this defines POINTED_BINDING, the binding of
// its buffer, and asks for GL_KHR_memory_scope_semantics.

// The complement of the leaf's number, so that 0 is none and the first leaf wins where several
// are equally near; and the bits of the depth, which is not negative.
layout(std430, binding = POINTED_BINDING) buffer Pointed { uint leaf_complement; uint depth_bits; };

void note_pointed(uint leaf, float depth) {
    atomicMax(leaf_complement, ~leaf, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
    atomicMax(depth_bits, floatBitsToUint(depth), gl_ScopeDevice, gl_StorageSemanticsNone,
              gl_SemanticsRelaxed);
}
