// Edges: the line of a segment, for the geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "edge_vertex.glsl"
