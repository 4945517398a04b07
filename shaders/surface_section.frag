// The surface pass, without shadows, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define ENVIRONMENT_BINDING 7
#define PAGES_BINDING 8
#define SECTION_BINDING 5
#include "surface_main.glsl"
