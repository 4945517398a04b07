// The surface pass, with the shadows of its lights, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOWED
#define SHADOW_TEXTURES_BINDING 9
#define ENVIRONMENT_BINDING 12
#define PAGES_BINDING 13
#define SECTION_BINDING 7
#include "surface_main.glsl"
