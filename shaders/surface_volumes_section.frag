// The surface pass, with the shadows of its lights by shadow volumes, cut by section planes.
#version 460
#extension GL_GOOGLE_include_directive : require
#define VOLUMES
#define ENVIRONMENT_BINDING 9
#define PAGES_BINDING 10
#define SECTION_BINDING 7
#include "surface_main.glsl"
