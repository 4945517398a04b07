// Materials, as `surfaces/materials.rs` packs them, and the textures they lie on.

struct Material {
    // Base colour as four unorm16; roughness and metallic; strength of occlusion as unorm16 and
    // flags.
    uvec4 factors;
    // Cutoff of alpha and scale of normals as floats; textures of the base colour, of roughness and
    // metallic.
    uvec4 cuts;
    // Three floats, and its texture.
    uvec4 emission;
    // Textures of normals and of occlusion; the rest is 0.
    uvec4 details;
};

const uint UNLIT_FLAG = 1u << 16;
// The texture of normals holds x and y alone.
const uint NORMALS_OF_TWO_CHANNELS_FLAG = 1u << 17;

vec4 base_colour_factor(uvec4 factors) {
    return vec4(unpackUnorm2x16(factors.x), unpackUnorm2x16(factors.y));
}
