// The surface pass, depth only, cut by section planes: cuts the holes of masked materials. Textures
// have an image each.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
#define INDEXED_TEXTURES
#define SECTION_BINDING 5
#include "surface_depth_main.glsl"
