// The surface pass, depth only: cuts the holes of masked materials.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 5
#include "material.glsl"
#include "surface_constants.glsl"
#include "texels.glsl"
#include "surface_alpha.glsl"

void main() {
    if (is_hole(base_colour())) discard;
}
