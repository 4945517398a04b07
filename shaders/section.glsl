// Section planes, for fragment shaders: which fragments they cut away. A shader that includes this
// defines SECTION_BINDING, the first of two bindings of storage buffers: the planes of the view,
// and the states of objects, which only vertex shaders read (`section_vertex.glsl`).
//
// A plane of the world is a plane of the image: of places in pixels and depths. So a fragment is on
// the kept side by where it is and how deep. Every pass that draws an object at the same depth
// decides the same, to the bit, and what is left is a part of the uncut object, at the same depths.

struct Section {
    // Of (pixels right and down of the middle, depth, 1): positive on the kept side.
    vec4 planes[6];
    vec2 middle; // of the view (pixels)
    uint count;
    uint mode;
};

layout(std430, binding = SECTION_BINDING) readonly buffer Sections { Section sections[]; };

// Kept is what one plane keeps, not what all keep.
const uint SECTION_UNION = 1u;

// The state of an object: a bit for each plane that keeps all of it, one for each that removes all
// of it, and whether the backs of its triangles show.
const uint SECTION_PLANES = 6u;
const uint SECTION_BACKS = 1u << 12;

// A bound on the rounding of depths and of the sum below, relative to its terms. Within it a
// fragment is kept.
const float SECTION_ROUNDING = 1.0 / 1048576.0;

// The place of a fragment at a depth.
vec3 section_place(float depth) {
    return vec3(gl_FragCoord.xy - sections[0].middle, depth);
}

bool plane_keeps(uint number, vec3 place) {
    vec4 plane = sections[0].planes[number];
    precise vec4 terms = vec4(plane.xyz * place, plane.w);
    precise float sum = (terms.x + terms.y) + (terms.z + terms.w);
    return sum >= -SECTION_ROUNDING * (abs(terms.x) + abs(terms.y) + abs(terms.z) + abs(terms.w));
}

// Whether a plane keeps a place of an object.
bool plane_keeps_of(uint state, uint number, vec3 place) {
    bool keeps_all = (state >> number & 1u) != 0u;
    bool removes_all = (state >> (number + SECTION_PLANES) & 1u) != 0u;
    return keeps_all || (!removes_all && plane_keeps(number, place));
}

// Whether section planes remove a place of an object.
bool planes_remove_at(uint state, vec3 place) {
    uint count = sections[0].count;
    uint keeping = 0u;
    for (uint number = 0u; number < count; ++number) {
        keeping += plane_keeps_of(state, number, place) ? 1u : 0u;
    }
    return sections[0].mode == SECTION_UNION ? keeping == 0u && count > 0u : keeping < count;
}

// Whether section planes remove a fragment of an object, of either side of it.
bool planes_remove(uint state) {
    return planes_remove_at(state, section_place(gl_FragCoord.z));
}

// Whether a fragment of an object is not drawn: it is removed, or of a back that does not show.
bool is_cut_away(uint state) {
    return (!gl_FrontFacing && (state & SECTION_BACKS) == 0u) || planes_remove(state);
}
