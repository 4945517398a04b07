// Edges: widens a line to a strip.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "edge_geometry.glsl"
