// The surface pass, veil of flares, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 7
#define SECTION_BINDING 5
#include "flare_veil_main.glsl"
