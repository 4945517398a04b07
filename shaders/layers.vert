// The layers pass: the opaque pass's positions.
#version 460
#extension GL_GOOGLE_include_directive : require
#define DEPTH_ONLY
#include "seen_vertex.glsl"
