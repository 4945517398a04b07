// Writes the commands of each range that are drawn into its list, behind those of the ranges before
// it, without gaps and in their order: what is drawn first where depths are equal is the same in
// every run. One workgroup per range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "listed.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Ranges { ListedRange ranges[]; };
layout(std430, binding = 1) readonly buffer Draws { IndirectDraw draws[]; };
layout(std430, binding = 2) readonly buffer Enabled { IndirectDraw enabled[]; };
layout(std430, binding = 3) readonly buffer Sizes { RangeSize sizes[]; };
layout(std430, binding = 4) writeonly buffer Commands { IndirectDraw commands[]; };
layout(std430, binding = 5) writeonly buffer Counts { uint counts[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint end;
    uint threshold;
};

// A bit per thread: set if its draw is drawn.
shared uint drawn[2];

void main() {
    uint number = first + gl_WorkGroupID.x;
    uint thread = gl_LocalInvocationID.x;
    ListedRange range = ranges[number];
    bool is_last = number + 1 == end || ranges[number + 1].list != range.list;
    uint size = sizes[number].drawn;
    uint before = sizes[number].before - sizes[range.first_of_list].before;
    uint place = range.first_command + before;
    if (is_last && thread == 0) {
        counts[range.list] = before + size;
    }
    if (size == 0) {
        return;
    }
    for (uint at = 0; at < range.count; at += gl_WorkGroupSize.x) {
        if (thread < 2) {
            drawn[thread] = 0;
        }
        barrier();
        uint draw = range.first + at + thread;
        IndirectDraw command = IndirectDraw(0, 0, 0, 0, 0);
        if (at + thread < range.count) {
            if (range.is_enabled == 1) {
                command = enabled[draw];
            } else {
                command = draws[draw];
            }
        }
        uint word = thread / 32;
        uint bit = thread % 32;
        if (command.instance_count > 0) {
            atomicOr(drawn[word], 1u << bit);
        }
        barrier();
        uint low = bitCount(drawn[0]);
        uint in_front = bitCount(drawn[word] & ((1u << bit) - 1)) + (word == 1 ? low : 0);
        if (command.instance_count > 0) {
            commands[place + in_front] = command;
        }
        place += low + bitCount(drawn[1]);
        barrier();
    }
}
