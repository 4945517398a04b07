// The base colour and the alpha of a surface, for fragments of the surface passes.

layout(location = 0) in vec4 uvs;           // two sets
layout(location = 1) in vec4 vertex_colour; // linear
layout(location = 2) flat in uvec4 material_factors;
layout(location = 3) flat in uvec4 material_cuts;

// Both passes of a masked surface must cut the same holes.
vec4 base_colour() {
    precise vec4 colour = base_colour_factor(material_factors) * vertex_colour;
    if (BASE_COLOUR_PAGES != 0u) colour *= texel(BASE_COLOUR_PAGES, material_cuts.z, uvs);
    return colour;
}

bool is_hole(vec4 base) {
    return base.a < uintBitsToFloat(material_cuts.x);
}
