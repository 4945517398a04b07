// The cap pass: a section through an object, in its colour, with a hatch that lies in the plane. It
// is lit as if from everywhere.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 2
#include "cap.glsl"

layout(location = 0) out vec4 colour;

const float LINE_WIDTH = 0.16; // of the distance between lines
const float LINE_SHARE = 0.45; // of the colour

void main() {
    Cap cap = caps[cap_number];
    float depth = cap_depth(cap);
    vec4 place = vec4(section_place(depth), 1.0);
    float across = dot(cap.hatch, place) / dot(cap.w, place);
    bool is_line = fract(across) < LINE_WIDTH;
    gl_FragDepth = depth;
    colour = depth > 0.0 ? vec4(cap.colour.rgb * (is_line ? LINE_SHARE : 1.0), 1.0) : vec4(0.0);
}
