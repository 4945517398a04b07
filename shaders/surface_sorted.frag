// The surface pass of transparent objects whose fragments are sorted, without shadows.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FRAGMENTS_BINDING 5
#define ENVIRONMENT_BINDING 6
#define PAGES_BINDING 7
#include "surface_main.glsl"
