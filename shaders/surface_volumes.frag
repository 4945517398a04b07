// The surface pass, with the shadows of its lights by shadow volumes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define VOLUMES
#define ENVIRONMENT_BINDING 7
#define PAGES_BINDING 8
#include "surface_main.glsl"
