// The surface pass, with the shadows of its lights.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOWED
#include "surface_main.glsl"
