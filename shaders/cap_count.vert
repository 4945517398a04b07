// The cap pass, counting: the opaque pass's positions to the bit.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cap_constants.glsl"
#include "instance.glsl"
#include "instance_number.glsl"
#include "snap.glsl"

layout(location = 0) in vec3 position;

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
#include "sprites.glsl"

invariant gl_Position;

void main() {
    vec4 clip = view_proj * vec4(vertex_from_anchor(instances[instance_number], position, view_proj, anchor.xyz), 1.0);
    gl_Position = snapped(clip, snap_steps);
}
