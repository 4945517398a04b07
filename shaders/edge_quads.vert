// Edges, where there is no geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "edge_quads_vertex.glsl"
