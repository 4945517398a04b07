// Edges, cut by section planes, where there is no geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 3
#include "edge_quads_vertex.glsl"
