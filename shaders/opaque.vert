// The opaque pass: places an object's vertices.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "opaque_vertex.glsl"
