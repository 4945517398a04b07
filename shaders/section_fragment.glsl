// Section planes, for fragment shaders of passes whose vertex shader includes
// `section_vertex.glsl`: `discard` a fragment if `is_cut_away(section_state)`.
#include "section.glsl"

layout(location = 14) flat in uint section_state;
