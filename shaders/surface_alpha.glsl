// The base colour and the alpha of a surface, for fragments of the surface passes.

layout(location = 0) centroid in vec4 covered_uvs;   // two sets
layout(location = 1) centroid in vec4 vertex_colour; // linear
layout(location = 2) flat in uvec4 material_factors;
layout(location = 3) flat in uvec4 material_cuts;
layout(location = 13) in float middle_alpha; // that of the vertex colour in the middle of the pixel

// Both passes of a masked surface must cut the same holes.
vec4 base_colour_of(vec4 uvs, vec4 colour_of_vertices) {
    precise vec4 colour = base_colour_factor(material_factors) * colour_of_vertices;
    if (BASE_COLOUR_PAGES != 0u) colour *= texel(BASE_COLOUR_PAGES, material_cuts.z, uvs);
    return colour;
}

vec4 base_colour() {
    return base_colour_of(at_centroid(covered_uvs), at_centroid(vertex_colour));
}

// The alpha that decides about a hole, or that flares are transmitted by. Where there are several
// samples that is the one in the middle of the pixel: on some drivers (Mesa's llvmpipe) centroids
// are those of the samples that pass the depth test, so draws before would decide about holes, and
// both passes would differ.
float mask_alpha(vec4 base) {
    return SEVERAL_SAMPLES ? base_colour_of(middle_uvs, vec4(vec3(1.0), middle_alpha)).a : base.a;
}

bool is_hole(vec4 base) {
    return mask_alpha(base) < uintBitsToFloat(material_cuts.x);
}
