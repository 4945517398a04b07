// The surface pass, depth only.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "surface_depth_vertex.glsl"
