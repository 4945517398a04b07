// The surface pass, veil of flares.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PAGES_BINDING 5
#include "flare_veil_main.glsl"
