// Counts the draws of each range that are drawn: none if no more showed than the threshold. One
// workgroup per range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "listed.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Ranges { ListedRange ranges[]; };
layout(std430, binding = 1) readonly buffer Draws { IndirectDraw draws[]; };
layout(std430, binding = 2) readonly buffer Enabled { IndirectDraw enabled[]; };
layout(std430, binding = 3) readonly buffer Queries { uint queries[]; };
layout(std430, binding = 4) readonly buffer Fragments { uint fragments[]; };
layout(std430, binding = 5) readonly buffer Computed { uint computed[]; };
layout(std430, binding = 6) writeonly buffer Sizes { RangeSize sizes[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint end;
    uint threshold; // 0 unless all results are numbers of samples
};

shared uint size;

uint result_of(ListedRange range) {
    switch (range.source) {
        case SOURCE_QUERIES: return queries[range.result];
        case SOURCE_FRAGMENTS: return fragments[range.result];
        default: return computed[range.result];
    }
}

void main() {
    uint number = first + gl_WorkGroupID.x;
    ListedRange range = ranges[number];
    if (gl_LocalInvocationID.x == 0) {
        size = 0;
    }
    barrier();
    if (result_of(range) > threshold) {
        for (uint at = gl_LocalInvocationID.x; at < range.count; at += gl_WorkGroupSize.x) {
            uint draw = range.first + at;
            uint instances =
                range.is_enabled == 1 ? enabled[draw].instance_count : draws[draw].instance_count;
            if (instances > 0) {
                atomicAdd(size, 1);
            }
        }
    }
    barrier();
    if (gl_LocalInvocationID.x == 0) {
        sizes[number].drawn = size;
    }
}
