// The flare pass, counts of transmitted blocks: a sample passes at as many levels as the
// transmittance lets through there.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "flare_block.glsl"

layout(location = 0) flat in uint number;
layout(location = 1) flat in float level; // 0 to 1

layout(std430, binding = 0) readonly buffer Blocks { FlareBlock blocks[]; };
layout(std430, binding = 1) readonly buffer Transmittance { uint transmittance[]; };

void main() {
    FlareBlock block = blocks[number];
    ivec2 place = ivec2(gl_FragCoord.xy) - block.target_low;
    uint taken = transmittance[block.first_cell + uint(place.y) * block.side + uint(place.x)];
    if (exp2(-float(taken) / STEPS_PER_HALVING) <= level) discard;
}
