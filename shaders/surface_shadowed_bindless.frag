// The surface pass, with the shadows of its lights. Textures have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#define SHADOWED
#define SHADOW_TEXTURES_BINDING 7
#define ENVIRONMENT_BINDING 10
#include "surface_main.glsl"
