// The parts that both phases of the pyramid strategy share: the boxes and draws of all leaves, the
// pixels that a box may cover, and the list of draws.

struct Box {
    vec3 low;
    uint triangles; // that are shown: a front and its back are one
    vec3 high;
    uint unused;
};

struct IndirectDraw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

struct Counters {
    uint draws;
    uint triangles_low;
    uint triangles_high;
    uint unused;
};

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };
layout(std430, binding = 1) readonly buffer Leaves { IndirectDraw leaves[]; };
// A value per leaf. Between frames: was visible in the last one. Between the phases: was drawn.
layout(std430, binding = 2) buffer Seen { uint seen[]; };
layout(std430, binding = 3) writeonly buffer List { IndirectDraw list[]; };
layout(std430, binding = 4) buffer Counts { Counters counters[]; };

layout(push_constant) uniform Constants {
    // Clip x, y and w, and view depth, of a point relative to the origin of the rays.
    vec4 row_x;     // w: how much a box grows where w is 1 (metres)
    vec4 row_y;     // w: the coordinate that bounds the rounding of the view
    vec4 row_w;
    vec4 row_depth; // w: the least view depth of a box that is tested
    vec3 origin;
    uint leaf_count;
    vec2 depth_terms; // of depth: the first, and the second over the view depth or, where w is 1
                      // throughout, times it
    float near;
    uint phase;
    uvec2 size;
    uint is_compact; // the list holds draws alone, or an entry for every leaf
};

// A bound on rounding, relative to the largest coordinate: more than `cull::Margin` takes, so that
// no rounding here can make it less conservative.
const float ROUNDING = 24.0 / 8388608.0;

struct Coverage {
    bool in_sight;
    bool too_near; // to say which pixels
    ivec2 first;
    ivec2 last;
    float nearest; // depth
};

float largest(vec3 v) {
    return max(max(v.x, v.y), v.z);
}

// True if some of a box may lie beyond none of the planes left, right, top, bottom and near.
bool is_in_sight(vec3 centre, vec3 extent) {
    vec3 planes[4] = vec3[](row_w.xyz + row_x.xyz, row_w.xyz - row_x.xyz,
                            row_w.xyz + row_y.xyz, row_w.xyz - row_y.xyz);
    bool in_sight = !(dot(row_depth.xyz, centre) + dot(abs(row_depth.xyz), extent) < near);
    for (int plane = 0; plane < 4; ++plane) {
        vec3 normal = planes[plane];
        in_sight = in_sight && !(dot(normal, centre) + row_w.w + dot(abs(normal), extent) < 0.0);
    }
    return in_sight;
}

// The pixels that a box may cover. The box is enlarged as in `cull::Margin`, whose proof then says:
// where the object owns a sample, the enlarged box holds a point that is as near, under a pixel
// away. Rounding here is far below what the box has grown by; on top, the rectangle grows by half a
// pixel and to whole pixels, the nearest depth by some units in its last place.
Coverage coverage(Box box) {
    const float DEPTH_SLACK = 1.0 / 1048576.0;
    // Where depth is affine in the view depth; relative to the constant.
    const float CONSTANT_SLACK = 1.0 / 262144.0;
    vec3 centre = (box.low * 0.5 + box.high * 0.5) - origin;
    vec3 extent = box.high * 0.5 - box.low * 0.5;
    float slack = ROUNDING * max(largest(max(abs(box.low), abs(box.high))), row_y.w);
    Coverage covers;
    // A leaf without an object has a box turned inside out.
    bool is_empty = box.low.x > box.high.x;
    covers.in_sight = !is_empty && is_in_sight(centre, extent + slack);

    float w = dot(row_w.xyz, centre) + row_w.w;
    float farthest = w + dot(abs(row_w.xyz), extent);
    extent += max(row_x.w * farthest, 0.0) + slack;
    float nearest = dot(row_depth.xyz, centre) - dot(abs(row_depth.xyz), extent);
    // Written so that NaN counts as too near.
    covers.too_near = !(nearest - slack > row_depth.w);
    bool has_eye = row_w.w == 0.0;
    float scaled = has_eye ? depth_terms.y / nearest : depth_terms.y * nearest;
    covers.nearest = depth_terms.x + scaled + abs(scaled) * DEPTH_SLACK + abs(depth_terms.x) * CONSTANT_SLACK;
    vec2 middle = vec2(dot(row_x.xyz, centre), dot(row_y.xyz, centre));
    vec3 step_x = row_x.xyz * extent;
    vec3 step_y = row_y.xyz * extent;
    vec3 step_w = row_w.xyz * extent;
    vec2 low = vec2(2.0);
    vec2 high = vec2(-2.0);
    for (int corner = 0; corner < 8; ++corner) {
        vec3 side = vec3((corner & 1) * 2 - 1, (corner & 2) - 1, (corner & 4) / 2 - 1);
        vec2 at = middle + vec2(dot(step_x, side), dot(step_y, side));
        at /= w + dot(step_w, side);
        low = min(low, at);
        high = max(high, at);
    }
    // To pixels: the clamp keeps everything that is on the image and makes it safe to convert.
    vec2 pixels = vec2(size);
    low = clamp((low * 0.5 + 0.5) * pixels - 0.5, vec2(-1.0), pixels);
    high = clamp((high * 0.5 + 0.5) * pixels + 0.5, vec2(-1.0), pixels);
    covers.first = max(ivec2(floor(low)), ivec2(0));
    covers.last = min(ivec2(floor(high)), ivec2(size) - 1);
    return covers;
}

// Puts a leaf on the list of this phase, or not.
void decide(uint leaf, bool drawn) {
    if (is_compact != 0 && !drawn) {
        return;
    }
    IndirectDraw draw = leaves[leaf];
    draw.instance_count = drawn ? 1 : 0;
    uint place = drawn ? atomicAdd(counters[phase].draws, 1) : 0;
    list[is_compact != 0 ? place : leaf] = draw;
    if (!drawn) {
        return;
    }
    uint triangles = boxes[leaf].triangles;
    uint before = atomicAdd(counters[phase].triangles_low, triangles);
    if (before + triangles < before) {
        atomicAdd(counters[phase].triangles_high, 1);
    }
}
