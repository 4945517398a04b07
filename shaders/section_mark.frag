// The outline's mark of an object that section planes cut: backs count, too, so that its caps are
// marked by what lies behind them.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 1
#include "section_fragment.glsl"

void main() {
    if (planes_remove(section_state)) discard;
}
