// The sky pass: a computed sky.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sky_main.glsl"
