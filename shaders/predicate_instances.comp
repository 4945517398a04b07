// Writes the answer of each test into the instance counts of the draws it decides about.
// One workgroup per decision: the threads share the range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "predicate.glsl"

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

layout(push_constant) uniform Constants {
    uint first;
    uint count;
    uint threshold; // 0 but for results that are numbers of samples
};

void main() {
    uint decision = first + gl_WorkGroupID.x;
    Decided range = decided[decision];
    uint shown = results[range.result] > threshold ? 1 : 0;
    if (range.per_leaf != 0) {
        if (gl_LocalInvocationID.x == 0) {
            box_draws[decision].instance_count = shown * range.count;
        }
        return;
    }
    for (uint draw = gl_LocalInvocationID.x; draw < range.count; draw += gl_WorkGroupSize.x) {
        draws[range.first + draw].instance_count = shown;
    }
}
