// The flare pass, counts: a block of whole pixels at the depth of its light, several times over
// where what a transmittance lets through is counted.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "flare_block.glsl"
#include "instance_number.glsl"

layout(std430, binding = 0) readonly buffer Blocks { FlareBlock blocks[]; };

layout(push_constant) uniform Constants {
    vec2 clip_per_pixel;
    uint levels;
};

layout(location = 0) flat out uint number;
layout(location = 1) flat out float level; // 0 to 1

// Two triangles over the unit square.
const ivec2 square[6] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 0), ivec2(1, 1), ivec2(0, 1));

void main() {
    number = instance_number / levels;
    level = (float(instance_number % levels) + 0.5) / float(levels);
    FlareBlock block = blocks[number];
    vec2 corner = vec2(block.low + square[gl_VertexIndex] * int(block.side));
    gl_Position = vec4(corner * clip_per_pixel - 1.0, block.depth, 1.0);
}
