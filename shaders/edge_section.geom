// Edges, cut by section planes: widens a line to a strip.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION
#include "edge_geometry.glsl"
