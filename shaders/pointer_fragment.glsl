// The pointer pass: a fragment as near as the finished image owns the pixel under the pointer.
#include "pointed.glsl"

layout(early_fragment_tests) in;

layout(location = 0) flat in uint leaf;

#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

void main() {
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
#endif
    note_pointed(leaf, gl_FragCoord.z);
}
