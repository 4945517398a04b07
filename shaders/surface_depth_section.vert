// The surface pass, depth only, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 5
#include "surface_depth_vertex.glsl"
