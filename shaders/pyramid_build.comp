// Builds up to three levels of the depth pyramid: the farthest depth under each texel. Depth is
// reversed, so the farthest is the smallest. A thread reads 8x8 texels and needs no other thread.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "pyramid_levels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) buffer Depths { float depths[]; };

layout(push_constant) uniform Constants {
    uvec2 size;  // of the level that is read
    uint start;  // where it lies
    uint levels; // to write, 1 to 3
};

vec4 read_row(uint row, uvec4 x) {
    return vec4(depths[row + x.x], depths[row + x.y], depths[row + x.z], depths[row + x.w]);
}

// Drops what lies beyond the edge of its level.
void write_texel(uint level_start, uvec2 level_size, uvec2 at, float farthest) {
    if (all(lessThan(at, level_size))) {
        depths[level_start + at.y * level_size.x + at.x] = farthest;
    }
}

void main() {
    uvec2 size_1 = size_above(size);
    uvec2 size_2 = size_above(size_1);
    uvec2 size_3 = size_above(size_2);
    uint start_1 = start + texels(size);
    uint start_2 = start_1 + texels(size_1);
    uint start_3 = start_2 + texels(size_2);
    uvec2 at_3 = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at_3, size_3))) {
        return;
    }
    float farthest_3 = 1.0;
    for (uint part_2 = 0; part_2 < 4; ++part_2) {
        uvec2 at_2 = at_3 * 2 + uvec2(part_2 & 1, part_2 >> 1);
        // 4x4 texels, read at once: loops of a fixed length are unrolled.
        uvec4 x = min(at_2.x * 4 + uvec4(0, 1, 2, 3), uvec4(size.x - 1));
        uvec4 row = start + min(at_2.y * 4 + uvec4(0, 1, 2, 3), uvec4(size.y - 1)) * size.x;
        vec4 upper = min(read_row(row.x, x), read_row(row.y, x));
        vec4 lower = min(read_row(row.z, x), read_row(row.w, x));
        vec4 farthest_1 = min(vec4(upper.xz, lower.xz), vec4(upper.yw, lower.yw));
        uvec2 at_1 = at_2 * 2;
        write_texel(start_1, size_1, at_1, farthest_1.x);
        write_texel(start_1, size_1, at_1 + uvec2(1, 0), farthest_1.y);
        write_texel(start_1, size_1, at_1 + uvec2(0, 1), farthest_1.z);
        write_texel(start_1, size_1, at_1 + uvec2(1, 1), farthest_1.w);
        vec2 pair = min(farthest_1.xy, farthest_1.zw);
        float farthest_2 = min(pair.x, pair.y);
        if (levels > 1) {
            write_texel(start_2, size_2, at_2, farthest_2);
        }
        farthest_3 = min(farthest_3, farthest_2);
    }
    if (levels > 2) {
        write_texel(start_3, size_3, at_3, farthest_3);
    }
}
