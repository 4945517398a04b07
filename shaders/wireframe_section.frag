// Edges of the drawn triangles, cut by section planes: a colour that stands out from all materials,
// with a trace of theirs.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 1
#include "section_fragment.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec3 albedo;

layout(location = 0) out vec4 colour;

void main() {
    if (is_cut_away(section_state)) discard;
    float light = 0.8 + 0.2 * normalize(world_normal).y;
    colour = vec4(mix(vec3(0.02, 0.9, 0.55), albedo, 0.2) * light, 1.0);
}
