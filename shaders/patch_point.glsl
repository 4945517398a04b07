// Points of Bezier patches, in the order of operations of `scene::evaluated`: nothing may be fused
// or reordered where positions are computed, so that both sides of an edge get equal bits.
//
// Who includes this declares `vec3 control_point(uint patch_index, uint place)` before.

const float LEAST_AREA = 1e-6;
const uint NUDGES = 3;
const float NUDGE[NUDGES] = float[](0.0, 1.0 / 64.0, 0.25);

// The places of the first control point and the step to the next along each side.
const uint SIDE_FIRST[4] = uint[](0, 3, 12, 0);
const uint SIDE_STEP[4] = uint[](1, 4, 1, 4);

struct CurvePoint {
    vec3 place;
    vec3 tangent; // a third of the derivative
};

vec3 between(vec3 a, vec3 b, float t) {
    precise vec3 way = b - a;
    precise vec3 part = way * t;
    precise vec3 place = a + part;
    return place;
}

CurvePoint curve(vec3 a, vec3 b, vec3 c, vec3 d, float t) {
    vec3 middle = between(b, c, t);
    vec3 low = between(between(a, b, t), middle, t);
    vec3 high = between(middle, between(c, d, t), t);
    return CurvePoint(between(low, high, t), high - low);
}

vec3 inside(uint patch_index, float u, float v) {
    vec3 rows[4];
    for (uint row = 0; row < 4; row++) {
        uint first = row * 4;
        rows[row] = curve(control_point(patch_index, first), control_point(patch_index, first + 1),
                          control_point(patch_index, first + 2),
                          control_point(patch_index, first + 3), u)
                        .place;
    }
    return curve(rows[0], rows[1], rows[2], rows[3], v).place;
}

// From the edge's own control points, in its canonical direction.
vec3 on_edge(uint patch_index, uint side_word, float u, float v) {
    uint side = (side_word - 1) / 2;
    bool is_reversed = side_word % 2 == 0;
    float along = side % 2 == 0 ? u : v;
    float t = is_reversed ? 1.0 - along : along;
    vec3 points[4];
    for (uint place = 0; place < 4; place++) {
        uint of_side = is_reversed ? 3 - place : place;
        points[place] = control_point(patch_index, SIDE_FIRST[side] + SIDE_STEP[side] * of_side);
    }
    return t >= 1.0 ? points[3] : curve(points[0], points[1], points[2], points[3], t).place;
}

vec3 normal(uint patch_index, float u, float v) {
    vec3 origin = control_point(patch_index, 0);
    vec3 relative[16];
    float reach = 0.0;
    for (uint place = 0; place < 16; place++) {
        relative[place] = control_point(patch_index, place) - origin;
        vec3 distances = abs(relative[place]);
        reach = max(reach, max(distances.x, max(distances.y, distances.z)));
    }
    if (reach == 0.0) {
        return vec3(0.0, 1.0, 0.0);
    }
    for (uint attempt = 0; attempt < NUDGES; attempt++) {
        float near_u = u + (0.5 - u) * NUDGE[attempt];
        float near_v = v + (0.5 - v) * NUDGE[attempt];
        CurvePoint rows[4];
        for (uint row = 0; row < 4; row++) {
            uint first = row * 4;
            rows[row] = curve(relative[first] / reach, relative[first + 1] / reach,
                              relative[first + 2] / reach, relative[first + 3] / reach, near_u);
        }
        vec3 tangent_u = curve(rows[0].tangent, rows[1].tangent, rows[2].tangent, rows[3].tangent,
                               near_v)
                             .place;
        vec3 tangent_v =
            curve(rows[0].place, rows[1].place, rows[2].place, rows[3].place, near_v).tangent;
        vec3 across = cross(tangent_u, tangent_v);
        float area = length(across);
        if (area > LEAST_AREA) {
            return across / area;
        }
    }
    return vec3(0.0, 1.0, 0.0);
}

// The position of a point and its normal, as `scene::EvaluatedPoint` holds them.
uvec4 evaluated_point(uint patch_index, uint side_word, float u, float v) {
    vec3 position =
        side_word == 0 ? inside(patch_index, u, v) : on_edge(patch_index, side_word, u, v);
    uint normal_bits = packSnorm4x8(vec4(normal(patch_index, u, v), 0.0));
    return uvec4(floatBitsToUint(position), normal_bits);
}
