// The positions of the seen pass, for passes that need nothing else, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_BINDING 1
#define DEPTH_ONLY
#include "seen_vertex.glsl"
