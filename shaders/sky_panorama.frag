// The sky pass: a panorama.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PANORAMA
#include "sky_main.glsl"
