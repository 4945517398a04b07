// The sky pass: what is seen where nothing is.
#version 460

layout(push_constant) uniform Constants {
    vec4 sky;
};

layout(location = 0) out vec4 colour;

void main() {
    colour = sky;
}
