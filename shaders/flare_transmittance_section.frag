// The surface pass, transmittance of flares, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 7
#define SECTION_BINDING 5
#include "flare_transmittance_main.glsl"
