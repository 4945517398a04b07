// The opaque pass: one directional light, plain diffuse.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "opaque_main.glsl"
