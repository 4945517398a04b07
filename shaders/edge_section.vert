// Edges, cut by section planes: the line of a segment, for the geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 3
#include "edge_vertex.glsl"
