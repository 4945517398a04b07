// The surface pass of transparent objects whose fragments are sorted, without shadows, cut by
// section planes. Textures have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#define SECTION_BINDING 5
#define FRAGMENTS_BINDING 6
#define ENVIRONMENT_BINDING 7
#include "surface_main.glsl"
