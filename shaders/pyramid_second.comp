// Phase 2 of the pyramid strategy: tests all leaves in the frustum against the farthest depths of
// the draws of phase 1, draws those that are visible and were not drawn, and notes the visible ones
// for the next frame.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "pyramid.glsl"
#include "pyramid_levels.glsl"

layout(std430, binding = 5) readonly buffer Depths { float depths[]; };

// True if every sample the box may cover is nearer than all of the box. Reads the lowest level at
// which the rectangle meets at most 4x4 texels, and all of these.
bool is_hidden(Coverage covers) {
    const int MOST = 4;
    int level = 0;
    uint start = 0;
    uvec2 level_size = size;
    while (any(greaterThanEqual((covers.last >> level) - (covers.first >> level), ivec2(MOST)))) {
        start += texels(level_size);
        level_size = size_above(level_size);
        ++level;
    }
    ivec2 first = covers.first >> level;
    ivec2 last = covers.last >> level;
    float farthest = 1.0;
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            farthest = min(farthest, depths[start + uint(y) * level_size.x + uint(x)]);
        }
    }
    return covers.nearest < farthest;
}

void main() {
    uint leaf = gl_GlobalInvocationID.x;
    if (leaf >= leaf_count) {
        return;
    }
    Coverage covers = coverage(boxes[leaf]);
    bool shows = covers.in_sight && (covers.too_near || !is_hidden(covers));
    bool was_drawn = seen[leaf] != 0;
    seen[leaf] = shows ? 1 : 0;
    decide(leaf, shows && !was_drawn);
}
