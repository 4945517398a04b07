// The corners of the box of an instance, on the grid of sub-pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "snap.glsl"

layout(location = 0) in vec3 low;
layout(location = 1) in vec3 high;

layout(push_constant) uniform View {
    mat4 view_proj;
    vec2 snap_steps;
};

layout(location = 0) flat out uint number;
layout(location = 1) out vec3 world;

void main() {
    world = mix(low, high, bvec3(gl_VertexIndex & 1, gl_VertexIndex & 2, gl_VertexIndex & 4));
    number = gl_InstanceIndex;
    gl_Position = snapped(view_proj * vec4(world, 1.0), snap_steps);
}
