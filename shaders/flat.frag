// Flat images over the scene: the atlas times the vertex colour, both sRGB-encoded and multiplied
// by alpha; what is blended is linear.
#version 460

layout(set = 0, binding = 0) uniform sampler2D atlas;

layout(location = 0) in vec2 texture_position;
layout(location = 1) in vec4 passed_colour;
layout(location = 0) out vec4 colour;

vec3 linear_of(vec3 encoded) {
    vec3 low = encoded / 12.92;
    vec3 high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return mix(high, low, lessThanEqual(encoded, vec3(0.04045)));
}

void main() {
    vec4 encoded = passed_colour * texture(atlas, texture_position);
    vec3 plain = encoded.a > 0.0 ? min(encoded.rgb / encoded.a, vec3(1.0)) : vec3(0.0);
    colour = vec4(linear_of(plain) * encoded.a, encoded.a);
}
