// Shadow volumes: adds a light's bit to the mask of each pixel whose count is not 0.
#version 460

// The stencil test comes first, although the shader writes memory.
layout(early_fragment_tests) in;

layout(std430, binding = 0) buffer Mask { uint mask[]; };

layout(push_constant) uniform Constants {
    uint width; // of the mask's rows
    uint bits;
    uint first; // value of the light's layer
};

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint place = first + pixel.y * width + pixel.x;
    if (place < mask.length()) atomicOr(mask[place], bits);
}
