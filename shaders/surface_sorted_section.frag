// The surface pass of transparent objects whose fragments are sorted, without shadows, cut by
// section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 5
#define FRAGMENTS_BINDING 6
#define ENVIRONMENT_BINDING 7
#define PAGES_BINDING 8
#include "surface_main.glsl"
