// The surface pass with shadows, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 7
#include "surface_vertex.glsl"
