// The pointer pass: finds the object that owns the pixel under the pointer.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require
#define POINTED_BINDING 1
#include "pointer_fragment.glsl"
