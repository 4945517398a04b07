// The object under a pointer. A shader that includes this defines POINTED_BINDING, the binding of
// its buffer, and asks for GL_KHR_memory_scope_semantics.

// Two values: the complement of the leaf's number, so that 0 is none and the first leaf wins where
// several are equally near; and the bits of the depth, which is not negative.
layout(std430, binding = POINTED_BINDING) buffer Pointed { uint pointed[]; };

void note_pointed(uint leaf, float depth) {
    atomicMax(pointed[0], ~leaf, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
    atomicMax(pointed[1], floatBitsToUint(depth), gl_ScopeDevice, gl_StorageSemanticsNone,
              gl_SemanticsRelaxed);
}
