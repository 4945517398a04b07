// Turns the result of each decision into a draw count: 0 if no more showed than the threshold, else
// the whole range, or the one command that draws its boxes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "predicate.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Results { uint results[]; };
layout(std430, binding = 1) readonly buffer AllDecided { Decided decided[]; };
layout(std430, binding = 2) writeonly buffer Counts { uint counts[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint count;
    uint threshold; // 0 but for results that are numbers of samples
};

void main() {
    if (gl_GlobalInvocationID.x >= count) {
        return;
    }
    uint decision = first + gl_GlobalInvocationID.x;
    Decided range = decided[decision];
    uint commands = range.reveal == REVEAL_BOXES ? 1 : range.count;
    counts[decision] = results[range.result] > threshold ? commands : 0;
}
