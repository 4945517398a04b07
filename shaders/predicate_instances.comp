// Writes the answer of each test into the instance counts of the draws it decides about.
// One workgroup per decision: the threads share the range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "predicate.glsl"
#include "draw_link.glsl"

layout(local_size_x = 64) in;

struct IndirectDraw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

layout(std430, binding = 0) readonly buffer Results { uint results[]; };
layout(std430, binding = 1) readonly buffer AllDecided { Decided decided[]; };
layout(std430, binding = 2) buffer Draws { IndirectDraw draws[]; };
layout(std430, binding = 3) buffer BoxDraws { BoxDraw box_draws[]; };
layout(std430, binding = 4) readonly buffer Links { DrawLink links[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint count;
    uint threshold; // 0 but for results that are numbers of samples
};

void main() {
    uint decision = first + gl_WorkGroupID.x;
    Decided range = decided[decision];
    bool shows = results[range.result] > threshold;
    if (range.reveal == REVEAL_BOXES && gl_LocalInvocationID.x == 0) {
        box_draws[decision].instance_count = shows ? range.count : 0;
    }
    if (range.reveal != REVEAL_DRAWS) {
        return;
    }
    for (uint draw = gl_LocalInvocationID.x; draw < range.count; draw += gl_WorkGroupSize.x) {
        uint number = range.first + draw;
        uint instances = LINKED ? links[number].instance_count : 1;
        draws[number].instance_count = shows ? instances : 0;
    }
}
