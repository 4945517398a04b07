// The surface pass, depth only, cut by section planes: cuts the holes of masked materials.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 7
#define SECTION_BINDING 5
#include "surface_depth_main.glsl"
