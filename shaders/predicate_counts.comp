// Turns the word of each test into a draw count: 0 if nothing showed, else the whole range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "predicate.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, binding = 1) readonly buffer AllDecided { Decided decided[]; };
layout(std430, binding = 2) writeonly buffer Counts { uint counts[]; };

layout(push_constant) uniform Constants {
    uint first_word;
    uint word_count;
};

void main() {
    if (gl_GlobalInvocationID.x >= word_count) {
        return;
    }
    uint word = first_word + gl_GlobalInvocationID.x;
    counts[word] = words[word] != 0 ? decided[word].count : 0;
}
