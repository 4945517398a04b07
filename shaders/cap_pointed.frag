// The cap pass, pointed at: notes the leaf of a cap that owns the pixel under the pointer. The
// stencil says if one does, so it is tested first.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require
#define SECTION_BINDING 2
#include "cap.glsl"
#define POINTED_BINDING 3
#include "pointed.glsl"

layout(early_fragment_tests) in;

void main() {
    Cap cap = caps[cap_number];
    note_pointed(cap.tail.z, cap_depth(cap));
}
