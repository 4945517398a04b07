// What the surface pass's fragments know of where they are and of what they are made.

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) in vec4 world_tangent; // w: sign of the bitangent
layout(location = 3) in vec4 uvs;           // two sets
layout(location = 4) in vec4 vertex_colour; // linear
layout(location = 5) flat in uvec2 lights_of_object; // slot of the list, how many
layout(location = 6) flat in uvec4 material_factors;
layout(location = 7) flat in uvec4 material_cuts;
layout(location = 8) flat in uvec4 material_emission;
layout(location = 9) flat in uvec4 material_details;

Material material_here() {
    return Material(material_factors, material_cuts, material_emission, material_details);
}

// Both passes of a masked surface must cut the same holes.
vec4 base_colour(Material material) {
    precise vec4 colour = base_colour_factor(material) * vertex_colour;
    if (BASE_COLOUR_PAGES != 0u) colour *= texel(BASE_COLOUR_PAGES, material.cuts.z, uvs);
    return colour;
}
