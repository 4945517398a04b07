// Shadow volumes: places vertices as the surfaces' passes do, to the bit, for the geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance.glsl"
#include "instance_number.glsl"
#include "snap.glsl"
#include "volume_constants.glsl"

layout(location = 0) in vec3 position;

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };

layout(location = 0) out vec3 corner_place;
layout(location = 1) out flat uint name;

invariant gl_Position;

void main() {
    Instance instance = instances[instance_number];
    vec3 place = from_anchor(instance, position, anchor.xyz);
    vec4 clip = view_proj() * vec4(place, 1.0);
    gl_Position = snapped(clip, steps);
    corner_place = place;
    name = uint(gl_VertexIndex);
}
