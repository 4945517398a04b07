// The seen pass: the opaque pass's positions to the bit, and the leaf that a vertex belongs to.
#include "instance.glsl"
#include "instance_number.glsl"
#include "snap.glsl"

layout(location = 0) in vec3 position;

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
#include "sprites.glsl"
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif

layout(push_constant) uniform Constants {
    mat4 view_proj; // of places relative to the anchor
    vec4 anchor;    // w unused
    vec2 snap_steps;
};

#ifndef DEPTH_ONLY
layout(location = 0) flat out uint leaf;
#endif

invariant gl_Position;

void main() {
    vec4 clip = view_proj * vec4(vertex_from_anchor(instances[instance_number], position, view_proj, anchor.xyz), 1.0);
    gl_Position = snapped(clip, snap_steps);
#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
#ifndef DEPTH_ONLY
    leaf = instance_number;
#endif
}
