// Flat pictures over the scene: the atlas times the vertex colour, both with alpha multiplied in.
#version 460

layout(set = 0, binding = 0) uniform sampler2D atlas;

layout(location = 0) in vec2 texture_position;
layout(location = 1) in vec4 passed_colour;
layout(location = 0) out vec4 colour;

// Vertex colours are sRGB-encoded, what is blended is linear.
vec3 linear_of(vec3 encoded) {
    vec3 low = encoded / 12.92;
    vec3 high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return mix(high, low, lessThanEqual(encoded, vec3(0.04045)));
}

void main() {
    colour = vec4(linear_of(passed_colour.rgb), passed_colour.a) * texture(atlas, texture_position);
}
