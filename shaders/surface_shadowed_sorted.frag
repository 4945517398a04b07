// The surface pass of transparent objects whose fragments are sorted, with the shadows of its
// lights.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOWED
#define FRAGMENTS_BINDING 7
#define SHADOW_TEXTURES_BINDING 8
#define ENVIRONMENT_BINDING 11
#define PAGES_BINDING 12
#include "surface_main.glsl"
