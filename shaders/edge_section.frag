// Edges, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 3
#include "edge_fragment.glsl"
