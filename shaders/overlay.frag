// The overlay of the view from above: plain colour with alpha.
#version 460

layout(location = 0) in vec4 passed_colour;
layout(location = 0) out vec4 colour;

void main() {
    colour = passed_colour;
}
