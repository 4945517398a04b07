// The overlay of the view from above: coloured triangles and lines in the world.
#version 460

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colour;

layout(push_constant) uniform Constants {
    mat4 view_proj; // of places relative to the anchor
    vec4 anchor;    // w unused
};

layout(location = 0) out vec4 passed_colour;

void main() {
    gl_Position = view_proj * vec4(position - anchor.xyz, 1.0);
    passed_colour = colour;
}
