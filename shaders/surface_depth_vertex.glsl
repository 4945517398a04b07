// The surface pass, depth only: the opaque pass's positions to the bit, and what cuts holes.
#include "instance.glsl"
#include "instance_number.glsl"
#include "material.glsl"
#include "snap.glsl"
#include "surface_constants.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv_first;
layout(location = 2) in vec2 uv_second;
layout(location = 3) in vec4 colour; // linear

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
#include "sprites.glsl"
layout(std430, binding = 1) readonly buffer Materials { Material materials[]; };
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif

layout(location = 0) out vec4 uvs;
layout(location = 1) out vec4 vertex_colour;
layout(location = 2) flat out uvec4 material_factors;
layout(location = 3) flat out uvec4 material_cuts;
layout(location = 10) out vec4 middle_uvs;
layout(location = 12) out float unit;
layout(location = 13) out float middle_alpha;

invariant gl_Position;

void main() {
    Instance instance = instances[instance_number];
    vec4 clip = view_proj * vec4(vertex_from_anchor(instance, position, view_proj, anchor), 1.0);
    gl_Position = snapped(clip, vec2(ambient_above.w, ambient_below.w));
#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
    uvs = vec4(uv_first, uv_second);
    if (SEVERAL_SAMPLES) {
        middle_uvs = uvs;
        unit = one_of(instance);
        middle_alpha = colour.a;
    }
    vertex_colour = colour;
    material_factors = materials[instance.tail.x].factors;
    material_cuts = materials[instance.tail.x].cuts;
}
