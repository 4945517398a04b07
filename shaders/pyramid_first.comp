// Phase 1 of the pyramid strategy: draws leaves that are in the frustum and were visible in the
// last frame.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "pyramid.glsl"

void main() {
    uint leaf = gl_GlobalInvocationID.x;
    if (leaf >= leaf_count) {
        return;
    }
    bool drawn = seen[leaf] != 0 && coverage(boxes[leaf]).in_sight;
    seen[leaf] = drawn ? 1 : 0;
    decide(leaf, drawn);
}
