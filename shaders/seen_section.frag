// The seen pass, cut by section planes: a fragment that passes the test against the finished depth
// owns a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require

layout(early_fragment_tests) in;

layout(location = 0) flat in uint leaf;

#define SECTION_BINDING 2
#include "section_fragment.glsl"

layout(std430, binding = 1) buffer Seen { uint seen[]; };

void main() {
    if (is_cut_away(section_state)) discard;
    // Many fragments write the same.
    atomicStore(seen[leaf], 1u, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
}
