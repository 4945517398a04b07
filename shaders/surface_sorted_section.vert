// The surface pass of transparent objects whose fragments are sorted, which section planes cut: all
// of them, so that none has a state.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SECTION_OF_ALL
#include "surface_vertex.glsl"
