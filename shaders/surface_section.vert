// The surface pass, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 5
#include "surface_vertex.glsl"
