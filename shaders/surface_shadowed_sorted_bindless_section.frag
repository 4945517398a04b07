// The surface pass of transparent objects whose fragments are sorted, with the shadows of its
// lights, cut by section planes. Textures have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#define SHADOWED
#define SECTION_BINDING 7
#define FRAGMENTS_BINDING 8
#define SHADOW_TEXTURES_BINDING 9
#define ENVIRONMENT_BINDING 12
#include "surface_main.glsl"
