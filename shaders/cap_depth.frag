// The cap pass, depth only.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 2
#include "cap.glsl"

void main() {
    gl_FragDepth = cap_depth(caps[cap_number]);
}
