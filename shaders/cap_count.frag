// The cap pass, counting: the faces behind a section plane. As many as are drawn there by this
// plane alone: so a surface shows where their number is even, and a cap where it is odd.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 2
#include "cap_constants.glsl"
#include "section.glsl"

void main() {
    if (!plane_keeps(caps[cap_number].tail.x, section_place(gl_FragCoord.z))) discard;
}
