// The cap pass, seen: notes the leaf of a cap that owns a pixel. The stencil says which pixels
// those are, so it is tested first.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require
#include "cap_constants.glsl"

layout(early_fragment_tests) in;

layout(std430, binding = 3) buffer Seen { uint seen[]; };

void main() {
    // Many fragments write the same.
    atomicStore(seen[caps[cap_number].tail.z], 1u, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
}
