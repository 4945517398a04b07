// The surface pass, transmittance of flares. Textures have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#include "flare_transmittance_main.glsl"
