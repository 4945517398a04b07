// The surface pass, without shadows, cut by section planes. Textures have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#define ENVIRONMENT_BINDING 7
#define SECTION_BINDING 5
#include "surface_main.glsl"
