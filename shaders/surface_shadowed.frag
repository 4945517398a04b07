// The surface pass, with the shadows of its lights.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOWED
#define SHADOW_TEXTURES_BINDING 7
#define ENVIRONMENT_BINDING 10
#define PAGES_BINDING 11
#include "surface_main.glsl"
