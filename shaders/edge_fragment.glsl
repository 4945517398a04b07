// Edges: one colour, in dashes or without gaps.
#include "edge_constants.glsl"

#ifdef SECTION_BINDING
#include "section_fragment.glsl"

layout(location = 1) in float rise;
#endif

layout(location = 0) in float along;

layout(location = 0) out vec4 drawn;

void main() {
#ifdef SECTION_BINDING
    // The edge itself is cut, and not the line before it.
    if (planes_remove_at(section_state, section_place(gl_FragCoord.z - rise))) discard;
#endif
    if (dash > 0.0 && along - floor(along / period) * period >= dash) discard;
    drawn = vec4(colour, 1.0);
}
