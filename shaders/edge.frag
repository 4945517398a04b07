// Edges: one colour, in dashes or without gaps.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "edge_fragment.glsl"
