// The surface pass of transparent objects whose fragments are sorted, with the shadows of its
// lights, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOWED
#define SECTION_BINDING 7
#define FRAGMENTS_BINDING 8
#define SHADOW_TEXTURES_BINDING 9
#define ENVIRONMENT_BINDING 12
#define PAGES_BINDING 13
#include "surface_main.glsl"
