// Passes of depth alone, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 1
#include "section_fragment.glsl"

void main() {
    if (is_cut_away(section_state)) discard;
}
