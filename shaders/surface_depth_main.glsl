// The surface pass, depth only: cuts the holes of masked materials.
#include "material.glsl"
#include "surface_constants.glsl"
#include "texels.glsl"
#include "surface_alpha.glsl"

void main() {
    if (is_hole(base_colour())) discard;
}
