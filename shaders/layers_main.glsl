// The layers pass: counts the surfaces at each pixel of a view, whatever hides them.
#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

layout(std430, binding = 1) buffer Layers { uint layers[]; };

layout(push_constant) uniform Constants {
    mat4 view_proj; // the first three are the vertex shader's
    vec4 anchor;
    vec2 snap_steps;
    uvec2 origin; // of the view in the image (pixels)
    uint width;   // of the view (pixels)
};

void main() {
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
#endif
    uvec2 place = uvec2(gl_FragCoord.xy) - origin;
    atomicAdd(layers[place.y * width + place.x], 1u);
}
