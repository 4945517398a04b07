// The lights of KHR_lights_punctual: the light that arrives at a place.

struct PunctualLight {
    vec4 position;  // w: 1 / range; without one -1 / the distance from which it is dark
    vec4 intensity; // lux or candela times colour; w: scale of the cone
    vec4 direction; // along which it shines, unit; w: offset of the cone
    vec3 right;     // of its picture: the direction to its right edge, over that edge's distance
    uint picture;   // packed as textures of materials are
};

layout(std430, binding = 3) readonly buffer Lights { PunctualLight lights[]; };
// For each object eight values: sixteen lights of sixteen bits, the strongest first.
layout(std430, binding = 4) readonly buffer LightLists { uint light_lists[]; };

const uint LIST_VALUES = 8;

uint light_of_list(uint slot, uint place) {
    uint value = light_lists[slot * LIST_VALUES + place / 2u];
    return (place & 1u) != 0u ? value >> 16 : value & 0xFFFFu;
}

// The part of a point's or spot's light that arrives at a place, from this direction and distance:
// the inverse square, which the recommended window takes to 0 at the light's range, and the cone.
// Without a range nothing arrives where it would be dark: objects, shadows and culling end there.
vec3 arriving(PunctualLight light, vec3 towards_light, float squared_distance, float inverse_distance) {
    float inverse_square = inverse_distance * inverse_distance;
    float share = squared_distance * light.position.w * light.position.w;
    float window = light.position.w < 0.0 ? float(share < 1.0) : clamp(1.0 - share * share, 0.0, 1.0);
    float falloff = window * inverse_square;
    if (SPOTS) {
        float cosine = -dot(light.direction.xyz, towards_light);
        float cone = clamp(cosine * light.intensity.w + light.direction.w, 0.0, 1.0);
        falloff *= cone * cone;
    }
    return light.intensity.rgb * falloff;
}
