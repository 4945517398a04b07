// Tests boxes against the depth so far: one workgroup per box, cell by cell of 8x8 pixels, then
// pixel by pixel in the cells that are open.
//
// At a pixel the ray of sight is inside of a box between its farthest entry and its nearest exit
// (the slab method). The depth at which it meets a plane is affine in the pixel's coordinates,
// whether rays come from an eye (depth is an affine function of 1 / w) or are parallel (w is 1, and
// depth affine in the way along the ray): its extremes over a cell, or over all that a rasteriser
// may take a pixel for, are its value in the middle and the slope times the reach. So entries are
// taken as near as they can be, exits as far, and a box that a rasteriser would show is never
// called hidden.
//
// Larger depths are nearer here; where depth is not reversed, all of it is turned around.
#version 460

layout(local_size_x = 64) in;

const uint CELL = 8;
const uint THREADS = 64;
// Relative to the terms of a depth, for its rounding here and in the rasteriser.
const float DEPTH_ROUNDING = 1.0 / 262144.0;
// Relative to the largest coordinate, for the rounding of transformed corners.
const float ROUNDING = 16.0 / 8388608.0;
// No plane is taken to be nearer to the eye than this (metres), nor closer to the direction of
// parallel rays (its sine), so that no depth is infinite.
const float NEAREST_PLANE = 1.0e-12;
// Stands for no entry and no exit.
const float BEYOND = 1.0e30;

struct Box {
    vec4 low;
    vec4 high;
};

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };
layout(std430, binding = 1) readonly buffer Depths { float depths[]; };
layout(std430, binding = 2) readonly buffer Grid { float grid[]; };
layout(std430, binding = 3) writeonly buffer Results { uint results[]; };

layout(push_constant) uniform Constants {
    vec3 origin; // the eye, or a point on the ray through the middle of the image
    float near;
    // The ray through the middle of the image, over a view depth of 1, and where w is 1 the way to
    // the next pixel to the right and to the next one down.
    vec3 forward;
    uint first;
    vec3 right;
    float reach_pixels; // from a sample to what the rasteriser may take it for
    vec3 down;
    float sign;         // of depth: 1 where it is reversed, else -1
    // Depth: the first, and the second over the view depth, or with parallel rays times it. Signed.
    vec2 depth_terms;
    uint has_eye;       // or else rays are parallel
    float coordinate;   // that bounds the rounding of these constants
    uvec2 size;
};

// Depths along planes, one plane of each axis: at the middle of the image, and their slopes.
struct Planes {
    vec3 middle;
    vec3 slope_x;
    vec3 slope_y;
    vec3 slack;
};

// A box in this view.
struct Slabs {
    Planes entries;
    Planes exits;
    Planes more_exits; // of the axes along which the eye is between both faces
};

shared uint shared_shows;
shared uint shared_open;
shared uint shared_cells[THREADS];

// Rays from an eye are at x * right + y * down + forward where w is 1: 1 / w at a plane is this
// over the plane's distance along the axis. Parallel rays begin at x * right + y * down: the way to
// the plane is its distance less this, over the ray's direction along the axis.
Planes planes_at(vec3 distance, vec3 direction) {
    bool eye = has_eye != 0;
    vec3 scale = depth_terms.y / (eye ? distance : direction);
    vec3 aside = eye ? scale : -scale;
    Planes planes = Planes(depth_terms.x + (eye ? direction : distance) * scale, right * aside,
                           down * aside, vec3(0.0));
    vec3 terms = abs((eye ? direction : distance) * scale) + abs(planes.slope_x) * float(size.x)
               + abs(planes.slope_y) * float(size.y);
    // The constant is lost first, also with its share of the eye's coordinates.
    terms += terms * (eye ? abs(depth_terms.x / depth_terms.y) * coordinate : 0.0) + abs(depth_terms.x);
    planes.slack = terms * DEPTH_ROUNDING;
    return planes;
}

// Planes that decide nothing on the axes of `absent`.
void leave_out(inout Planes planes, bvec3 absent, float depth) {
    planes.middle = mix(planes.middle, vec3(depth), absent);
    planes.slope_x = mix(planes.slope_x, vec3(0.0), absent);
    planes.slope_y = mix(planes.slope_y, vec3(0.0), absent);
    planes.slack = mix(planes.slack, vec3(0.0), absent);
}

// `low` and `high` are relative to the origin. An eye is before the low face, behind the high face
// or between both; one that is infinitely far away is on the side that parallel rays come from.
Slabs slabs_of(vec3 low, vec3 high) {
    bool eye = has_eye != 0;
    bvec3 before = greaterThan(eye ? low : forward, vec3(0.0));
    bvec3 behind = eye ? lessThan(high, vec3(0.0)) : not(before);
    bvec3 between = not(bvec3(uvec3(before) | uvec3(behind)));
    // What is divided by is kept away from 0 on its side of it: distances along the axis, or the
    // direction of parallel rays.
    vec3 to_low = eye ? mix(min(low, -NEAREST_PLANE), max(low, NEAREST_PLANE), before) : low;
    vec3 to_high = eye ? mix(max(high, NEAREST_PLANE), min(high, -NEAREST_PLANE), behind) : high;
    vec3 direction =
        eye ? forward : mix(min(forward, -NEAREST_PLANE), max(forward, NEAREST_PLANE), before);
    Slabs slabs;
    slabs.entries = planes_at(mix(to_low, to_high, behind), direction);
    slabs.exits = planes_at(mix(to_high, to_low, behind), direction);
    slabs.more_exits = planes_at(to_low, direction);
    leave_out(slabs.entries, between, BEYOND);
    leave_out(slabs.more_exits, not(between), -BEYOND);
    return slabs;
}

vec3 nearest(Planes planes, vec2 at, float reach) {
    return planes.middle + planes.slope_x * at.x + planes.slope_y * at.y + planes.slack
         + (abs(planes.slope_x) + abs(planes.slope_y)) * reach;
}

vec3 farthest(Planes planes, vec2 at, float reach) {
    return planes.middle + planes.slope_x * at.x + planes.slope_y * at.y - planes.slack
         - (abs(planes.slope_x) + abs(planes.slope_y)) * reach;
}

float least(vec3 v) {
    return min(min(v.x, v.y), v.z);
}

float largest(vec3 v) {
    return max(max(v.x, v.y), v.z);
}

// True if the box may be as near as `depth` anywhere up to `reach` pixels, in x and in y, from
// `at`, which is counted from the middle of the image.
bool may_show(Slabs slabs, vec2 at, float reach, float depth) {
    float entry = least(nearest(slabs.entries, at, reach));
    float exit = max(largest(farthest(slabs.exits, at, reach)),
                     largest(farthest(slabs.more_exits, at, reach)));
    // A plane behind the eye is met beyond the depth of what is infinitely far away.
    return entry >= depth && entry >= exit && (has_eye == 0 || entry > depth_terms.x);
}

// The first and the last pixel that the box may cover; the last is smaller if it covers none.
ivec4 rectangle(vec3 low, vec3 high, out bool is_before_the_eye) {
    // The rows of the inverse of (right, down, forward).
    vec3 row_z = cross(right, down) / dot(cross(right, down), forward);
    vec3 row_x = cross(down, forward) / dot(cross(down, forward), right);
    vec3 row_y = cross(forward, right) / dot(cross(forward, right), down);
    vec2 first = vec2(BEYOND);
    vec2 last = vec2(-BEYOND);
    is_before_the_eye = true;
    for (int corner = 0; corner < 8; ++corner) {
        vec3 point = mix(low, high, bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0));
        float w = has_eye != 0 ? dot(row_z, point) : 1.0;
        is_before_the_eye = is_before_the_eye && w > 0.5 * near;
        vec2 at = vec2(dot(row_x, point), dot(row_y, point)) / w;
        first = min(first, at);
        last = max(last, at);
    }
    vec2 middle = vec2(size) * 0.5;
    first = clamp(first + middle - 1.0, vec2(-1.0), vec2(size));
    last = clamp(last + middle + 1.0, vec2(-1.0), vec2(size));
    return ivec4(max(ivec2(floor(first)), ivec2(0)), min(ivec2(floor(last)), ivec2(size) - 1));
}

void main() {
    uint thread = gl_LocalInvocationID.x;
    uint test = first + gl_WorkGroupID.x;
    vec3 low = boxes[test].low.xyz;
    vec3 high = boxes[test].high.xyz;
    float slack = max(largest(max(abs(low), abs(high))), coordinate) * ROUNDING + NEAREST_PLANE;
    low = (low - origin) - slack;
    high = (high - origin) + slack;

    bool is_before_the_eye;
    ivec4 pixels = rectangle(low, high, is_before_the_eye);
    Slabs slabs = slabs_of(low, high);
    uvec2 grid_size = (size + CELL - 1) / CELL;
    uvec2 first_cell = uvec2(pixels.xy) / CELL;
    uvec2 cells = uvec2(0);
    if (is_before_the_eye && all(lessThanEqual(pixels.xy, pixels.zw))) {
        cells = uvec2(pixels.zw) / CELL - first_cell + 1;
    }
    vec2 middle = vec2(size) * 0.5;
    if (thread == 0) {
        shared_shows = is_before_the_eye ? 0 : 1;
        shared_open = 0;
    }
    barrier();

    uint count = cells.x * cells.y;
    for (uint base = 0; base < count; base += THREADS) {
        uint number = base + thread;
        if (number < count) {
            uvec2 cell = first_cell + uvec2(number % cells.x, number / cells.x);
            vec2 at = vec2(cell * CELL) + 0.5 * float(CELL) - middle;
            float reach = 0.5 * float(CELL - 1) + reach_pixels;
            float depth = grid[cell.y * grid_size.x + cell.x];
            if (may_show(slabs, at, reach, depth)) {
                shared_cells[atomicAdd(shared_open, 1)] = cell.x | cell.y << 16;
            }
        }
        barrier();
        uint open = shared_open;
        bool shows = false;
        for (uint place = 0; place < open && !shows; ++place) {
            uint cell = shared_cells[place];
            uvec2 pixel = uvec2(cell & 0xffff, cell >> 16) * CELL + uvec2(thread % CELL, thread / CELL);
            if (all(lessThan(pixel, size))) {
                float depth = sign * depths[pixel.y * size.x + pixel.x];
                shows = may_show(slabs, vec2(pixel) + 0.5 - middle, reach_pixels, depth);
            }
        }
        if (shows) {
            shared_shows = 1;
        }
        barrier();
        bool is_over = shared_shows != 0;
        if (thread == 0) {
            shared_open = 0;
        }
        barrier();
        if (is_over) {
            break;
        }
    }
    if (thread == 0) {
        results[test] = shared_shows;
    }
}
