// The seen pass: the opaque pass's positions.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "seen_vertex.glsl"
