// The surface pass: places vertices of a scene with surfaces, at the opaque pass's positions to the
// bit.
#include "instance.glsl"
#include "instance_number.glsl"
#include "material.glsl"
#include "snap.glsl"
#include "surface_constants.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 tint;    // w: share of the object's tint
layout(location = 2) in vec4 normal;  // w: whether the mesh has both sides of each triangle
layout(location = 3) in vec4 tangent; // w: sign of the bitangent
layout(location = 4) in vec2 uv_first;
layout(location = 5) in vec2 uv_second;
layout(location = 6) in vec4 colour; // linear

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
#include "sprites.glsl"
layout(std430, binding = 1) readonly buffer Materials { Material materials[]; };
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif
#ifdef SECTION_OF_ALL
layout(location = 14) flat out uint section_state;
#endif

layout(location = 0) out vec4 uvs;
layout(location = 1) out vec4 vertex_colour;
layout(location = 2) flat out uvec4 material_factors;
layout(location = 3) flat out uvec4 material_cuts;
layout(location = 4) flat out uvec4 material_emission;
layout(location = 5) flat out uvec4 material_details;
layout(location = 6) out vec3 world_position; // relative to the anchor
layout(location = 7) out vec3 world_normal;
layout(location = 8) out vec4 world_tangent; // w: sign of the bitangent
layout(location = 9) flat out uvec2 lights_of_object; // slot of the list, how many
layout(location = 10) out vec4 middle_uvs;
layout(location = 11) out vec3 middle_position;
layout(location = 12) out float unit;
layout(location = 13) out float middle_alpha;

// Depth drawn by the opaque pass is found again, to the bit.
invariant gl_Position;

// By a power of two, so that nothing is rounded: squares of tiny numbers would be zero.
vec3 near_one(vec3 v, float largest) {
    int exponent;
    frexp(largest, exponent);
    return ldexp(v, ivec3(-exponent));
}

float largest_of(vec3 v) {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

vec3 unit_or_zero(vec3 v) {
    v = near_one(v, largest_of(v));
    float squared = dot(v, v);
    return squared > 0.0 ? v * inversesqrt(squared) : vec3(0.0);
}

void main() {
    Instance instance = instances[instance_number];
    vec3 place = vertex_from_anchor(instance, position, view_proj, anchor);
    vec4 clip = view_proj * vec4(place, 1.0);
    gl_Position = snapped(clip, vec2(ambient_above.w, ambient_below.w));

#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
#ifdef SECTION_OF_ALL
    section_state = 0u;
#endif

    // Normals follow the cofactors of the matrix, which stay finite for flat objects; they turn
    // around where it mirrors, and so would bitangents.
    vec3 own_normal = normal.xyz;
    vertex_colour = colour;
    vertex_colour.rgb *= mix(vec3(1.0), tint_of_object(instance), tint.w);
    if (SPRITES && instance.tail.w != 0u) {
        sprite_look(instance, position, vertex_colour.rgb, own_normal);
        vertex_colour.a = 1.0;
    }
    vec3 x = instance.rows[0].xyz;
    vec3 y = instance.rows[1].xyz;
    vec3 z = instance.rows[2].xyz;
    float largest = max(largest_of(x), max(largest_of(y), largest_of(z)));
    x = near_one(x, largest);
    y = near_one(y, largest);
    z = near_one(z, largest);
    float turn = dot(x, cross(y, z)) < 0.0 ? -1.0 : 1.0;
    // Of a triangle with both sides a mirror shows the other one, which has all of this turned: the
    // normal stays what it is then, and the tangent turns instead.
    bool has_both_sides = normal.w > 0.5;
    float tangent_turn = has_both_sides ? turn : 1.0;
    turn = has_both_sides ? 1.0 : turn;
    vec3 cofactors = vec3(dot(cross(y, z), own_normal), dot(cross(z, x), own_normal), dot(cross(x, y), own_normal));
    world_position = place;
    world_normal = turn * unit_or_zero(cofactors);
    vec3 world_along = unit_or_zero(direction_to_world(instance, tangent.xyz));
    world_tangent = vec4(tangent_turn * world_along, turn * tangent.w);
    uvs = vec4(uv_first, uv_second);
    if (SEVERAL_SAMPLES) {
        middle_uvs = uvs;
        middle_position = place;
        unit = one_of(instance);
        middle_alpha = vertex_colour.a;
    }

    lights_of_object = uvec2(instance.tail.y, lights_of(instance));
    uint material = instance.tail.x;
    material_factors = materials[material].factors;
    material_cuts = materials[material].cuts;
    material_emission = materials[material].emission;
    material_details = materials[material].details;
}
