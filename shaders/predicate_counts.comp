// Turns the word of each decision into two draw counts: 0 if nothing showed, else the whole range and
// the one command that draws its boxes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "predicate.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, binding = 1) readonly buffer AllDecided { Decided decided[]; };
layout(std430, binding = 2) writeonly buffer Counts { uint counts[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint count;
};

void main() {
    if (gl_GlobalInvocationID.x >= count) {
        return;
    }
    uint decision = first + gl_GlobalInvocationID.x;
    Decided range = decided[decision];
    uint shown = words[range.word] != 0 ? range.count : 0;
    counts[2 * decision] = shown;
    counts[2 * decision + 1] = min(shown, 1);
}
