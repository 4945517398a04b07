// The shadows of lights by shadow volumes: each light has a bit per pixel, in the mask that the
// volume pass has written for the view that is drawn.

// Four values about the mask: the origin of the view in pixels of the image, and its size, 0 where
// there is no mask and all is lit. Then for each light 0 without shadows, else one more than the
// number of its bit; each layer of the mask has 32.
layout(std430, binding = 5) readonly buffer MaskedLights { uint masked_lights[]; };
layout(std430, binding = 6) readonly buffer ShadowMask { uint shadow_mask[]; };

const uint HEAD_VALUES = 4u;

// The share of a light that a pixel gets: all or nothing.
float unshadowed(uint light) {
    uint value = HEAD_VALUES + light;
    if (value >= masked_lights.length() || masked_lights[value] == 0u) return 1.0;
    uint bit = masked_lights[value] - 1u;
    uvec2 size = uvec2(masked_lights[2], masked_lights[3]);
    // Wraps around above and left of the view.
    uvec2 pixel = uvec2(gl_FragCoord.xy) - uvec2(masked_lights[0], masked_lights[1]);
    if (pixel.x >= size.x || pixel.y >= size.y) return 1.0;
    uint place = ((bit >> 5u) * size.y + pixel.y) * size.x + pixel.x;
    if (place >= shadow_mask.length()) return 1.0;
    return (shadow_mask[place] >> (bit & 31u) & 1u) != 0u ? 0.0 : 1.0;
}
