// The opaque pass, depth only, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 1
#define DEPTH_ONLY
#include "opaque_vertex.glsl"
