// Edges: one colour, in dashes or without gaps.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "edge_constants.glsl"

layout(location = 0) in float along;

layout(location = 0) out vec4 drawn;

void main() {
    if (dash > 0.0 && along - floor(along / period) * period >= dash) discard;
    drawn = vec4(colour, 1.0);
}
