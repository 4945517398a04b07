// The surface pass, without shadows.
#version 460
#extension GL_GOOGLE_include_directive : require
#define ENVIRONMENT_BINDING 5
#define PAGES_BINDING 6
#include "surface_main.glsl"
