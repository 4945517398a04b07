// The shadows of lights: filtered comparisons with shadow maps (depth is reversed), as the crate
// `shadows` plans them. The samples of a filter are those of a disk, jittered and stratified,
// another disk for each pixel of a tile (Uralsky, GPU Gems 2, chapter 17).

struct ShadowLight {
    uint first_face;
    uint faces;     // 0 without shadows; of a sun those of one view
    float width;    // of its penumbras in metres
    float blend;    // of a sun: the share of half a cascade's side that blends into the next one
};

struct ShadowFace {
    mat4 view_proj; // of places relative to its own anchor
    vec4 plane_x;   // the planes around the anchor in x, y and z of clip space
    vec4 plane_y;
    vec4 plane_z;
    vec4 tile;      // origin and side in texels, layer
    vec4 depth;     // depth is x + y / distance (a sun: x + y * distance); z: its change over the
                    // whole tile on a slope of 1 (others: per depth); w: tiles per metre at 1 m
    vec4 anchor;    // the place in the world; w unused
};

layout(std430, binding = 5) readonly buffer ShadowLights { ShadowLight shadow_lights[]; };
layout(std430, binding = 6) readonly buffer ShadowFaces { ShadowFace shadow_faces[]; };
layout(binding = SHADOW_TEXTURES_BINDING) uniform sampler2DArrayShadow shadow_maps;
layout(binding = SHADOW_TEXTURES_BINDING + 1) uniform sampler2DArray shadow_depths;
layout(binding = SHADOW_TEXTURES_BINDING + 2) uniform sampler3D disks;

const uint SINGLE = 0u;
const uint PCF3 = 1u;
const uint ADAPTIVE = 2u;
const uint PCSS12 = 3u;
const uint FIXED64 = 4u;
const uint PCSS64 = 5u;

// Texels of `disks` behind each other, two samples each; the first four are the outermost ring.
const int PAIRS = 32;
const int RING_PAIRS = 4;
// Filters reach so far at most, in shares of a tile: local maps have as much beyond their cone.
const float REACH_MAX = 0.05;
// Steeper slopes than this hardly get any light: their depth changes too much within a texel.
const float SLOPE_MAX = 32.0;
// By so much farther than its blocker a receiver has a penumbra of a sun's whole width (PCSS).
const float SUN_DISTANCE_M = 10.0;

// A place on a surface as a face sees it.
struct Receiver {
    vec2 place;    // in the tile, 0 to 1
    float depth;
    vec2 slope;    // change of the depth over the tile
    float bias;    // towards the light
    float radius;  // of the filter, in shares of the tile
    float floor;   // what is deeper blocks nothing
};

// The normal of the triangle itself: shading normals are not those of the plane that a map holds.
vec3 facet_normal() {
    return unit_or(cross(dFdx(world_position), dFdy(world_position)), unit_or(world_normal, vec3(0.0, 1.0, 0.0)));
}

// The place on the surface relative to the anchor of a face. Both anchors are near: far from the
// origin of the world nothing is lost to large coordinates.
vec3 from_face(ShadowFace face) {
    return world_position + (anchor - face.anchor.xyz);
}

vec4 clip_of(ShadowFace face) {
    return face.view_proj * vec4(from_face(face), 1.0);
}

// A surface is as deep elsewhere as its plane is. Between a sample and the four texels that it is
// compared with, that changes by the slope over up to a texel; the rest pays for vertices that a
// rasteriser moves onto its grid of sub-pixels, which has 16 steps at least.
Receiver receiver_of(ShadowFace face, vec4 clip, vec3 facet, float width, bool is_sun) {
    vec3 ndc = clip.xyz / clip.w;
    vec4 plane = vec4(facet, -dot(facet, from_face(face)));
    vec3 towards = vec3(dot(face.plane_x, plane), dot(face.plane_y, plane), dot(face.plane_z, plane));
    float unit = is_sun ? face.depth.z : face.depth.z * ndc.z;
    vec2 slope = abs(towards.z) > 0.0 ? towards.xy * (-2.0 / towards.z) : vec2(0.0);
    float steepest = SLOPE_MAX * unit;
    float steep = length(slope);
    slope = steep > steepest ? slope * (steepest / steep) : slope;
    float texel = 1.0 / face.tile.z;
    float rounding = 2e-6 * (is_sun ? 1.0 : ndc.z);
    float bias = 1.25 * (abs(slope.x) + abs(slope.y)) * texel + 0.1 * unit * texel + rounding;
    float radius = 0.5 * width * face.depth.w / (is_sun ? 1.0 : clip.w);
    // Nothing is farther than the background, which blocks nothing: receivers may lie beyond all
    // casters. Of a lamp nothing blocks that is twice as far as the receiver, however steep it is.
    float floor = is_sun ? 0.0 : 0.5 * ndc.z;
    return Receiver(ndc.xy * 0.5 + 0.5, ndc.z, slope, bias, radius, floor);
}

// The place in the layer of a place in the tile, so that no texel of another tile is read.
vec3 in_layer(ShadowFace face, vec2 place) {
    vec2 texel = face.tile.xy + clamp(place * face.tile.z, 0.5, face.tile.z - 0.5);
    return vec3(texel / vec2(textureSize(shadow_maps, 0).xy), face.tile.w);
}

// The depth from which on a blocker shadows the receiver.
float nearest_blocked(Receiver at, vec2 away) {
    return max(at.depth + dot(at.slope, away) + at.bias, at.floor);
}

float compared(ShadowFace face, Receiver at, vec2 away) {
    float depth = nearest_blocked(at, away);
    return texture(shadow_maps, vec4(in_layer(face, at.place + away), depth));
}

vec4 pair_of(int pair) {
    ivec2 tile = ivec2(gl_FragCoord.xy) % textureSize(disks, 0).xy;
    return texelFetch(disks, ivec3(tile, pair), 0);
}

float compared_pair(ShadowFace face, Receiver at, int pair) {
    vec4 two = pair_of(pair) * at.radius;
    return compared(face, at, two.xy) + compared(face, at, two.zw);
}

float filtered(ShadowFace face, Receiver at, int first, int pairs, int stride) {
    float sum = 0.0;
    for (int pair = 0; pair < pairs; ++pair) sum += compared_pair(face, at, first + pair * stride);
    return sum;
}

float distance_of(ShadowFace face, float depth, bool is_sun) {
    return is_sun ? (depth - face.depth.x) / face.depth.y : face.depth.y / max(depth - face.depth.x, 1e-9);
}

// The mean distance of what is nearer to the light than the receiver, and its share of the samples.
vec2 blockers(ShadowFace face, Receiver at, int pairs, bool is_sun) {
    float sum = 0.0;
    float count = 0.0;
    int stride = PAIRS / pairs;
    for (int pair = 0; pair < pairs; ++pair) {
        vec4 two = pair_of(pair * stride + pair % stride) * at.radius;
        for (int half_of = 0; half_of < 2; ++half_of) {
            vec2 away = half_of == 0 ? two.xy : two.zw;
            float found = textureLod(shadow_depths, in_layer(face, at.place + away), 0.0).r;
            if (found > nearest_blocked(at, away)) {
                sum += distance_of(face, found, is_sun);
                count += 1.0;
            }
        }
    }
    return count > 0.0 ? vec2(sum / count, count / float(2 * pairs)) : vec2(0.0);
}

float soft(ShadowFace face, Receiver at, float texel, bool is_sun) {
    bool is_fine = SHADOW_FILTER == PCSS64;
    vec2 blocked = blockers(face, at, is_fine ? 16 : 4, is_sun);
    if (blocked.y == 0.0) return 1.0;
    float receiver = distance_of(face, at.depth, is_sun);
    float behind = max(receiver - blocked.x, 0.0);
    float share = is_sun ? behind / SUN_DISTANCE_M : behind / max(blocked.x, 1e-3);
    at.radius = max(min(at.radius * min(share, 1.0), REACH_MAX), texel);
    if (is_fine) return filtered(face, at, 0, PAIRS, 1) / float(2 * PAIRS);
    return filtered(face, at, 1, 6, 5) / 12.0;
}

// The share of a light that a place on a surface gets.
float share_of(ShadowFace face, Receiver at, bool is_sun) {
    float texel = 1.0 / face.tile.z;
    if (SHADOW_FILTER == SINGLE) return compared(face, at, vec2(0.0));
    if (SHADOW_FILTER == PCF3) {
        float sum = 0.0;
        for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x) sum += compared(face, at, vec2(x, y) * texel);
        }
        return sum / 9.0;
    }
    at.radius = max(min(at.radius, REACH_MAX), texel);
    if (SHADOW_FILTER == PCSS12) return soft(face, at, texel, is_sun);
    if (SHADOW_FILTER == PCSS64) return soft(face, at, texel, is_sun);
    if (SHADOW_FILTER == FIXED64) return filtered(face, at, 0, PAIRS, 1) / float(2 * PAIRS);
    // Where the whole edge of the disk agrees, so does what lies within. One loop, which ends
    // there: drivers that mask branches instead of skipping them skip the rest of a loop.
    float sum = 0.0;
    int pairs = PAIRS;
    for (int pair = 0; pair < pairs; ++pair) {
        sum += compared_pair(face, at, pair);
        bool is_edge = pair + 1 == RING_PAIRS;
        if (is_edge && (sum == 0.0 || sum == float(2 * RING_PAIRS))) pairs = RING_PAIRS;
    }
    return sum / float(2 * pairs);
}

// The share of a directional light: by the first cascade that holds the place and its filter, and
// in the outer part of that also by the next one; beyond the last one all of the light arrives.
float sunlit(uint light, vec3 facet) {
    if (light >= shadow_lights.length()) return 1.0;
    ShadowLight shadow = shadow_lights[light];
    uint first = shadow.first_face + shadow_view * shadow.faces;
    float sum = 0.0;
    float rest = 1.0;
    for (uint number = 0; number < shadow.faces; ++number) {
        ShadowFace face = shadow_faces[first + number];
        vec4 clip = clip_of(face);
        float reach = max(abs(clip.x), abs(clip.y));
        float wanted = min(max(0.5 * shadow.width * face.depth.w, 1.5 / face.tile.z), REACH_MAX);
        float inside = 1.0 - 2.0 * wanted - reach;
        if (inside >= 0.0) {
            float here = rest * (shadow.blend > 0.0 ? min(inside / shadow.blend, 1.0) : 1.0);
            if (here > 0.0) sum += here * share_of(face, receiver_of(face, clip, facet, shadow.width, true), true);
            rest -= here;
            if (rest <= 0.0) return sum;
        }
    }
    return sum + rest;
}

// The side of a cube (+x, -x, +y, -y, +z, -z) that a direction from its middle meets.
uint side_of(vec3 direction) {
    vec3 size = abs(direction);
    if (size.x >= size.y && size.x >= size.z) return direction.x > 0.0 ? 0u : 1u;
    if (size.y >= size.z) return direction.y > 0.0 ? 2u : 3u;
    return direction.z > 0.0 ? 4u : 5u;
}

// The share of a point or spot light, which is `away` from the place.
float lit(uint light, vec3 away, vec3 facet) {
    if (light >= shadow_lights.length()) return 1.0;
    ShadowLight shadow = shadow_lights[light];
    if (shadow.faces == 0u) return 1.0;
    ShadowFace face = shadow_faces[shadow.first_face + (shadow.faces == 6u ? side_of(-away) : 0u)];
    vec4 clip = clip_of(face);
    // Nothing lies between a light and what touches it.
    if (clip.w <= 0.0 || clip.z >= clip.w) return 1.0;
    return share_of(face, receiver_of(face, clip, facet, shadow.width, false), false);
}
