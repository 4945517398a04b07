// Adds the results of a query in all views of a rendering: a device may leave the samples of all
// views in the first result, or those of each view in its own.
#version 460

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer OfViews { uint of_views[]; };
layout(std430, binding = 1) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Constants {
    uint first;
    uint count;
    uint views;
};

void main() {
    if (gl_GlobalInvocationID.x >= count) {
        return;
    }
    uint query = first + gl_GlobalInvocationID.x;
    uint sum = 0;
    for (uint view = 0; view < views; ++view) {
        uint samples = of_views[query * views + view];
        // At most the largest number: a sum that wraps around to 0 would hide what shows.
        sum = sum > 0xffffffffu - samples ? 0xffffffffu : sum + samples;
    }
    results[query] = sum;
}
