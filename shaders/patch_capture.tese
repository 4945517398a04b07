// Computes a point of a Bezier patch, which transform feedback captures: the same as
// `patch_points.comp` computes there, to the bit.
#version 460
#extension GL_GOOGLE_include_directive : require

// Vulkan draws v downwards: what is clockwise there is anticlockwise with v upwards.
layout(quads, equal_spacing, cw) in;

layout(location = 0) in vec3 passed_place[];
layout(location = 1) patch in uvec4 passed_sides;

// The position, and the normal as snorm8; see `scene::EvaluatedPoint`.
layout(location = 0, xfb_buffer = 0, xfb_offset = 0, xfb_stride = 16) out uvec4 evaluated;

// The highest level: all parameters are multiples of its inverse.
const float FINEST = 64.0;

vec3 control_point(uint patch_index, uint place) { return passed_place[place]; }

#include "patch_point.glsl"

// What `scene::SurfacePoint::side` holds for a point.
uint side_word(float u, float v) {
    uint side = v == 0.0 ? 0 : u == 1.0 ? 1 : v == 1.0 ? 2 : u == 0.0 ? 3 : 4;
    return side == 4 ? 0 : 1 + 2 * side + (passed_sides[side] & 1);
}

void main() {
    // Without the rounding of the device.
    vec2 at = round(gl_TessCoord.xy * FINEST) / FINEST;
    evaluated = evaluated_point(0, side_word(at.x, at.y), at.x, at.y);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
