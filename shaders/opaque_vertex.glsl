// The opaque pass: places an object's vertices.
#include "instance.glsl"
#include "instance_number.glsl"
#include "opaque_constants.glsl"
#include "snap.glsl"

layout(location = 0) in vec3 position;
#ifndef DEPTH_ONLY
layout(location = 1) in vec4 normal; // w unused
layout(location = 2) in vec4 colour; // linear; alpha is the share of the object's tint
#endif

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
#include "sprites.glsl"
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif

#ifndef DEPTH_ONLY
layout(location = 0) out vec3 world_normal;
layout(location = 1) out vec3 albedo;
#endif

// The seen pass finds these positions again, to the bit.
invariant gl_Position;

void main() {
    Instance instance = instances[instance_number];
    vec4 at_anchor = vec4(ambient_below.w, ambient_below.w, anchor.w, ambient_above.w);
    mat4 view_proj = mat4(axes[0], axes[1], axes[2], at_anchor);
    vec4 clip = view_proj * vec4(vertex_from_anchor(instance, position, view_proj, anchor.xyz), 1.0);
    gl_Position = snapped(clip, vec2(towards_sun.w, sun.w));
#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
#ifndef DEPTH_ONLY
    world_normal = direction_to_world(instance, normal.xyz);
    albedo = colour.rgb * mix(vec3(1.0), uintBitsToFloat(instance.tail.rgb), colour.a);
#endif
}
