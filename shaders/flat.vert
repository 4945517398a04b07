// Flat images over the scene (text, graphs): triangles in pixels from the upper left.
#version 460

layout(location = 0) in vec2 position;
layout(location = 1) in vec2 texture_position;
layout(location = 2) in vec4 colour;

layout(push_constant) uniform Constants {
    vec2 clip_per_pixel;
};

layout(location = 0) out vec2 passed_texture_position;
layout(location = 1) out vec4 passed_colour;

void main() {
    gl_Position = vec4(position * clip_per_pixel - 1.0, 0.0, 1.0);
    passed_texture_position = texture_position;
    passed_colour = colour;
}
