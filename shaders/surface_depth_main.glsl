// The surface pass, depth only: cuts the holes of masked materials.
#include "material.glsl"
#include "surface_constants.glsl"
#include "texels.glsl"
#include "surface_alpha.glsl"
#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

void main() {
    if (is_hole(base_colour())) discard;
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
#endif
}
