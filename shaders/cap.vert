// The cap pass: the part of the view that an object may cover.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cap_constants.glsl"

void main() {
    vec4 area = caps[cap_number].area;
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(mix(area.xy, area.zw, corner), 0.5, 1.0);
}
