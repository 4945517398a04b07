// Edges: one colour, in dashes or without gaps.
#include "edge_constants.glsl"

#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

layout(location = 0) in float along;

layout(location = 0) out vec4 drawn;

void main() {
#ifdef SECTION_BINDING
    if (planes_remove(section_state)) discard;
#endif
    if (dash > 0.0 && along - floor(along / period) * period >= dash) discard;
    drawn = vec4(colour, 1.0);
}
