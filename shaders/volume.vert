// Shadow volumes: places vertices as the surfaces' passes do, to the bit, for the geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance.glsl"
#include "instance_number.glsl"
#include "snap.glsl"
#include "volume_constants.glsl"

layout(location = 0) in vec3 position;

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };

layout(location = 0) out vec3 world_position;
layout(location = 1) out flat uint name;

invariant gl_Position;

void main() {
    Instance instance = instances[instance_number];
    vec3 world = to_world(instance, position);
    vec4 clip = view_proj * vec4(world, 1.0);
    gl_Position = snapped(clip, steps);
    world_position = world;
    name = uint(gl_VertexIndex);
}
