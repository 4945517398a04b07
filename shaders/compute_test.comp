// Tests boxes against the depth so far: one workgroup per box, cell by cell of 8x8 pixels, then
// pixel by pixel in the cells that are open.
//
// At a pixel the ray from the eye is inside of a box between its farthest entry and its nearest
// exit (the slab method). Reversed depth is proportional to 1 / w, so the depth at which the ray
// meets a plane is affine in the pixel's coordinates: its extremes over a cell, or over all that a
// rasteriser may take a pixel for, are its value in the middle and the slope times the reach. So
// entries are taken as near as they can be, exits as far, and a box that a rasteriser would show is
// never called hidden.
#version 460

layout(local_size_x = 64) in;

const uint CELL = 8;
const uint THREADS = 64;
// Relative to the terms of a depth, for its rounding here and in the rasteriser.
const float DEPTH_ROUNDING = 1.0 / 262144.0;
// Relative to the largest coordinate, for the rounding of transformed corners.
const float ROUNDING = 16.0 / 8388608.0;
// No plane is taken to be nearer to the eye than this (metres), so that no depth is infinite.
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
    vec3 eye;
    float near;
    // The direction with view depth 1 through the middle of the image, and its change per pixel
    // to the right and per pixel down.
    vec3 forward;
    uint first;
    vec3 right;
    float reach_pixels; // from a sample to what the rasteriser may take it for
    vec3 down;
    uint unused;
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

Planes planes_at(vec3 distance) {
    vec3 scale = near / distance;
    Planes planes = Planes(forward * scale, right * scale, down * scale, vec3(0.0));
    vec3 terms = abs(planes.middle) + abs(planes.slope_x) * float(size.x)
               + abs(planes.slope_y) * float(size.y);
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

// `low` and `high` are relative to the eye.
Slabs slabs_of(vec3 low, vec3 high) {
    bvec3 before = greaterThan(low, vec3(0.0));
    bvec3 behind = lessThan(high, vec3(0.0));
    bvec3 between = not(bvec3(uvec3(before) | uvec3(behind)));
    // Distances along the axis, kept away from 0 on the side where they are.
    vec3 to_low = mix(min(low, -NEAREST_PLANE), max(low, NEAREST_PLANE), before);
    vec3 to_high = mix(max(high, NEAREST_PLANE), min(high, -NEAREST_PLANE), behind);
    Slabs slabs;
    slabs.entries = planes_at(mix(to_low, to_high, behind));
    slabs.exits = planes_at(mix(to_high, to_low, behind));
    slabs.more_exits = planes_at(to_low);
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
    return entry >= depth && entry >= exit && entry > 0.0;
}

// The first and the last pixel that the box may cover; the last is smaller if it covers none.
ivec4 rectangle(vec3 low, vec3 high, out bool is_before_the_eye) {
    vec3 across = right / dot(right, right);
    vec3 along = down / dot(down, down);
    vec2 first = vec2(BEYOND);
    vec2 last = vec2(-BEYOND);
    is_before_the_eye = true;
    for (int corner = 0; corner < 8; ++corner) {
        vec3 point = mix(low, high, bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0));
        float w = dot(forward, point);
        is_before_the_eye = is_before_the_eye && w > 0.5 * near;
        vec2 at = vec2(dot(across, point), dot(along, point)) / w;
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
    float coordinate = max(largest(max(abs(low), abs(high))), largest(abs(eye)));
    float slack = coordinate * ROUNDING + NEAREST_PLANE;
    low = (low - eye) - slack;
    high = (high - eye) + slack;

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
                float depth = depths[pixel.y * size.x + pixel.x];
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
