// Copies the depth of an image with several samples per pixel: of each pixel the farthest, so that
// what is hidden behind the copy is hidden behind every sample. Depth is reversed, so the farthest
// is the smallest.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) writeonly buffer Depths { float depths[]; };
layout(binding = 1) uniform sampler2DMS depth_image;

layout(push_constant) uniform Constants {
    uvec2 origin; // of the area that is copied
    uvec2 size;
    uint samples;
};

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, size))) {
        return;
    }
    float farthest = 1.0;
    for (uint number = 0; number < samples; ++number) {
        farthest = min(farthest, texelFetch(depth_image, ivec2(origin + at), int(number)).r);
    }
    depths[at.y * size.x + at.x] = farthest;
}
