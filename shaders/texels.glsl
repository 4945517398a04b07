// Texels of materials. A texture lies on a page, an array of images of one size; or, with
// INDEXED_TEXTURES defined, it has an image of its own, which is found by its number.

// The transform from texture coordinates to those of one texture.
struct TextureTransform {
    vec4 axes; // columns of a 2x2 matrix
    vec4 origin;
};

layout(std430, binding = 2) readonly buffer TextureTransforms { TextureTransform transforms[]; };
#ifdef INDEXED_TEXTURES
layout(set = 1, binding = 0) uniform sampler2DArray textures[];
#else
layout(binding = PAGES_BINDING) uniform sampler2DArray pages[12];
#endif

// All bits of a place: four and eleven, around that of the set of coordinates.
const uint NO_TEXTURE = 0xFFEFu;

layout(location = 10) in vec4 middle_uvs; // two sets, in the middle of the pixel
layout(location = 12) centroid in float unit;

// What was taken at the centroid. Some drivers (Mesa's llvmpipe) take it there, but its perspective
// in the middle of the pixel: what is 1 at all vertices has the same error.
vec4 at_centroid(vec4 value) {
    return SEVERAL_SAMPLES ? value / unit : value;
}

vec2 set_of(uint packed, vec4 sets) {
    return (packed & 16u) != 0u ? sets.zw : sets.xy;
}

bool has_texture(uint packed) {
    return (packed & NO_TEXTURE) != NO_TEXTURE;
}

// The number of a texture with an image of its own.
uint texture_number(uint packed) {
    return (packed & 15u) | ((packed & 0xFFE0u) >> 1);
}

// The texel of a texture on one of the `used` pages, white if there is none. Arrays of pages are
// indexed by constants only, so no feature is needed; textures with an image of their own are all
// on pages that are used. Fragments of a quad belong to one draw, and with it to one material: they
// take the same branch, and derivatives are defined.
vec4 texel(const uint used, uint packed, vec4 uvs) {
    vec2 uv = set_of(packed, uvs);
    // Of coordinates that were not transformed yet: beyond a triangle's edge, where only
    // derivatives are looked for, some drivers read zeros from buffers (Mesa's llvmpipe does).
    vec2 even = SEVERAL_SAMPLES ? set_of(packed, middle_uvs) : uv;
    vec2 step_x = dFdx(even);
    vec2 step_y = dFdy(even);
    bool has_steps = SEVERAL_SAMPLES;
    if (TRANSFORMED) {
        TextureTransform transform = transforms[packed >> 16];
        mat2 axes = mat2(transform.axes.xy, transform.axes.zw);
        uv = axes * uv + transform.origin.xy;
        step_x = axes * step_x;
        step_y = axes * step_y;
        has_steps = true;
    }
    vec4 found = vec4(1.0);
#ifdef INDEXED_TEXTURES
    if (used != 0u && has_texture(packed)) {
        uint number = texture_number(packed);
        vec3 place = vec3(uv, 0.0);
        found = has_steps ? textureGrad(textures[nonuniformEXT(number)], place, step_x, step_y)
                          : texture(textures[nonuniformEXT(number)], place);
    }
#else
    uint page = packed & 15u;
    vec3 place = vec3(uv, float((packed >> 5) & 2047u));
#define TEXEL_OF_PAGE(number) \
    if ((used & (1u << number)) != 0u && page == number) \
        found = has_steps ? textureGrad(pages[number], place, step_x, step_y) : texture(pages[number], place)
    TEXEL_OF_PAGE(0);
    TEXEL_OF_PAGE(1);
    TEXEL_OF_PAGE(2);
    TEXEL_OF_PAGE(3);
    TEXEL_OF_PAGE(4);
    TEXEL_OF_PAGE(5);
    TEXEL_OF_PAGE(6);
    TEXEL_OF_PAGE(7);
    TEXEL_OF_PAGE(8);
    TEXEL_OF_PAGE(9);
    TEXEL_OF_PAGE(10);
    TEXEL_OF_PAGE(11);
#undef TEXEL_OF_PAGE
#endif
    return found;
}
