// The surface pass, transmittance of flares.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 5
#include "flare_transmittance_main.glsl"
