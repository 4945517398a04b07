// Texels of materials: the page that a texture lies on, and its place there.

// The transform from texture coordinates to those of one texture.
struct TextureTransform {
    vec4 axes; // columns of a 2x2 matrix
    vec4 origin;
};

layout(std430, binding = 2) readonly buffer TextureTransforms { TextureTransform transforms[]; };
layout(binding = PAGES_BINDING) uniform sampler2DArray pages[12];

const uint NO_PAGE = 15;

bool has_texture(uint packed) {
    return (packed & 15u) != NO_PAGE;
}

// The texel of a texture on one of the `used` pages, white if there is none. Arrays of samplers are
// indexed by constants only, so no feature is needed. Fragments of a quad belong to one draw, and
// with it to one material: they take the same branch, and derivatives are defined.
vec4 texel(const uint used, uint packed, vec4 uvs) {
    vec2 uv = (packed & 16u) != 0u ? uvs.zw : uvs.xy;
    // Of coordinates that were not transformed yet: beyond a triangle's edge, where only
    // derivatives are looked for, some drivers read zeros from buffers (Mesa's llvmpipe does).
    vec2 step_x = dFdx(uv);
    vec2 step_y = dFdy(uv);
    if (TRANSFORMED) {
        TextureTransform transform = transforms[packed >> 16];
        mat2 axes = mat2(transform.axes.xy, transform.axes.zw);
        uv = axes * uv + transform.origin.xy;
        step_x = axes * step_x;
        step_y = axes * step_y;
    }
    uint page = packed & 15u;
    vec3 place = vec3(uv, float((packed >> 5) & 2047u));
    vec4 found = vec4(1.0);
#define TEXEL_OF_PAGE(number) \
    if ((used & (1u << number)) != 0u && page == number) \
        found = TRANSFORMED ? textureGrad(pages[number], place, step_x, step_y) : texture(pages[number], place)
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
    return found;
}
