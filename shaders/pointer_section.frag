// The pointer pass, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require
#define POINTED_BINDING 1
#define SECTION_BINDING 2
#include "pointer_fragment.glsl"
