// The host's own vertex shader: one box per instance, with vertices on the sub-pixel grid, as
// proxies expect.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "snap.glsl"

layout(push_constant) uniform Constants {
    mat4 clip_from_world;
    vec2 snap_steps;
};

// Bit-identical in every pipeline that draws the boxes.
invariant gl_Position;

void main() {
    // A wall, and behind it a thousand boxes in rows.
    uint n = gl_InstanceIndex;
    vec3 low = n == 0 ? vec3(-4.0, -3.0, -6.0) : vec3(n % 20, n / 20 % 10, n / 200) * vec3(0.7, 0.7, -1.3) - vec3(7.0, 3.5, 12.0);
    vec3 size = n == 0 ? vec3(8.0, 6.0, 0.5) : vec3(0.45);
    vec3 corner = vec3(gl_VertexIndex & 1, gl_VertexIndex >> 1 & 1, gl_VertexIndex >> 2);
    gl_Position = snapped(clip_from_world * vec4(low + corner * size, 1.0), snap_steps);
}
