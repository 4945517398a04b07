// Writes new elements over old ones of an array that holds one element per leaf.
#version 460

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Leaves { uint leaves[]; };
layout(std430, binding = 1) readonly buffer Elements { uint elements[]; };
layout(std430, binding = 2) writeonly buffer Array { uint array[]; };

layout(push_constant) uniform Constants {
    uint element_values;
    uint value_count; // of all elements together
};

void main() {
    // As many threads as there are groups for; neighbours write neighbouring values.
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint value = gl_GlobalInvocationID.x; value < value_count; value += stride) {
        uint leaf = leaves[value / element_values];
        array[leaf * element_values + value % element_values] = elements[value];
    }
}
