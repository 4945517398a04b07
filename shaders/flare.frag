// The flare pass: soft sprites without textures. What they output is added to the image.
#version 460

layout(location = 0) in vec2 place; // 1 at the sides
layout(location = 1) flat in vec3 sprite_colour;
layout(location = 2) flat in uint shape;

layout(location = 0) out vec4 colour;

const uint GHOST = 1;

void main() {
    float distance = length(place);
    float soft = max(1.0 - distance, 0.0);
    // A glow: a small bright middle in a wide faint disk.
    float strength = 0.35 * soft * soft + 0.65 * pow(soft, 8.0);
    if (shape == GHOST) {
        float edge = 1.0 - smoothstep(0.8, 1.0, distance);
        strength = edge * (0.5 + 0.5 * distance * distance);
    }
    colour = vec4(sprite_colour * strength, 0.0);
}
