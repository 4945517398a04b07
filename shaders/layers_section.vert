// The layers pass: the opaque pass's positions, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 2
#define DEPTH_ONLY
#include "seen_vertex.glsl"
