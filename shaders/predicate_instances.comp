// Writes the answer of each query into the instance counts of the draws it decides about.
// One workgroup per word: the threads share the range.
#version 460

layout(local_size_x = 64) in;

struct DrawRange {
    uint first;
    uint count;
};

struct IndirectDraw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

layout(std430, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, binding = 1) readonly buffer Ranges { DrawRange ranges[]; };
layout(std430, binding = 2) buffer Draws { IndirectDraw draws[]; };

layout(push_constant) uniform Constants {
    uint first_word;
    uint word_count;
};

void main() {
    uint word = first_word + gl_WorkGroupID.x;
    uint shown = words[word] != 0 ? 1 : 0;
    DrawRange range = ranges[word];
    for (uint draw = gl_LocalInvocationID.x; draw < range.count; draw += gl_WorkGroupSize.x) {
        draws[range.first + draw].instance_count = shown;
    }
}
