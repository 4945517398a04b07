// The surface pass, transmittance of flares: a transparent fragment in front of a light takes its
// alpha of the light, at that pixel of the light's block.
#include "material.glsl"
#include "surface_constants.glsl"
#include "texels.glsl"
#include "surface_alpha.glsl"
#include "flare_block.glsl"
#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

layout(early_fragment_tests) in;

layout(std430, binding = 3) readonly buffer Blocks { FlareBlock blocks[]; };
layout(std430, binding = 4) buffer Transmittance { uint transmittance[]; };

void main() {
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
#endif
    // At least a 65536th is let through, so that sums stay within their range.
    float alpha = mask_alpha(base_colour());
    float through = max(1.0 - clamp(alpha, 0.0, 1.0), exp2(-16.0));
    uint taken = uint(round(-log2(through) * STEPS_PER_HALVING));
    for (uint number = 0; number < uint(blocks.length()); ++number) {
        FlareBlock block = blocks[number];
        ivec2 place = ivec2(gl_FragCoord.xy) - block.target_low;
        bool is_inside = all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, ivec2(block.side)));
        // Depth is reversed.
        if (is_inside && gl_FragCoord.z > block.depth) {
            atomicAdd(transmittance[block.first_cell + uint(place.y) * block.side + uint(place.x)], taken);
        }
    }
}
