// The sky pass: one colour, linear; sRGB is encoded by the attachment.
#version 460

layout(push_constant) uniform Constants {
    vec4 sky;
};

layout(location = 0) out vec4 colour;

void main() {
    colour = sky;
}
