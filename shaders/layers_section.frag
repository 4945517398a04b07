// The layers pass, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 2
#include "layers_main.glsl"
