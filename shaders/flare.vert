// The flare pass: a square for each sprite.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance_number.glsl"

struct Sprite {
    vec2 middle; // in normalised device coordinates, as the radius
    vec2 radius;
    vec3 colour;
    uint shape;
};

layout(std430, binding = 0) readonly buffer Sprites { Sprite sprites[]; };

layout(location = 0) out vec2 place; // 1 at the sides
layout(location = 1) flat out vec3 sprite_colour;
layout(location = 2) flat out uint shape;

// Two triangles.
const vec2 square[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

void main() {
    Sprite sprite = sprites[instance_number];
    place = square[gl_VertexIndex];
    sprite_colour = sprite.colour;
    shape = sprite.shape;
    gl_Position = vec4(sprite.middle + sprite.radius * place, 0.0, 1.0);
}
