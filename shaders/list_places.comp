// Adds up the draws of the ranges before each range: a single workgroup, so that the work grows
// with the ranges and not with their square. Each thread adds up a run of ranges.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "listed.glsl"

layout(local_size_x = 128) in;

layout(std430, binding = 0) buffer Sizes { RangeSize sizes[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint end;
    uint threshold;
};

// The sum of the runs of a thread and of all before it.
shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint thread = gl_LocalInvocationID.x;
    uint per_thread = (end - first + gl_WorkGroupSize.x - 1) / gl_WorkGroupSize.x;
    uint run = min(first + thread * per_thread, end);
    uint run_end = min(run + per_thread, end);
    uint sum = 0;
    for (uint number = run; number < run_end; number++) {
        sum += sizes[number].drawn;
    }
    sums[thread] = sum;
    barrier();
    for (uint distance = 1; distance < gl_WorkGroupSize.x; distance *= 2) {
        uint before = thread >= distance ? sums[thread - distance] : 0;
        barrier();
        sums[thread] += before;
        barrier();
    }
    uint before = sums[thread] - sum;
    for (uint number = run; number < run_end; number++) {
        sizes[number].before = before;
        before += sizes[number].drawn;
    }
}
