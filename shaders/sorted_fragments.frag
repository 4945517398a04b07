// The sorted fragments pass: blends the fragments of each pixel over the image, from the nearest to
// the farthest, whatever the order in which they were stored.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FRAGMENTS_BINDING 0
#include "fragments.glsl"

// Of all views of a frame: fragments, those without room, those beyond BLENDED_MOST of a pixel.
layout(std430, binding = 1) buffer Counts { uint counts[]; };

layout(location = 0) out vec4 colour; // multiplied by alpha

// The fragments that are sorted in one walk through a list. Pixels with more walk again.
const uint SORTED = 16u;

// Whether a fragment (depth, colour, number) comes before another. Depth is reversed. Of equally
// near ones the colour decides, so that no order of draws does; the number, which depends on that,
// decides between those that are the same in all else.
bool is_before(uvec4 a, uvec4 b) {
    if (a.x != b.x) return a.x > b.x;
    if (a.y != b.y) return a.y > b.y;
    if (a.z != b.z) return a.z > b.z;
    return a.w > b.w;
}

void main() {
    uint place_of_first = list_place();
    if (place_of_first == FRAGMENTS_HEAD) {
        uint stored = fragments[STORED];
        atomicAdd(counts[0], stored);
        atomicAdd(counts[1], stored - min(stored, fragments[ROOM]));
    }
    uint first = fragments[place_of_first];
    if (first == 0u) discard;
    uint most = fragments[BLENDED_MOST];
    vec3 light = vec3(0.0);
    float through = 1.0;
    uvec4 nearest[SORTED];
    uvec4 last = uvec4(0xFFFFFFFFu); // before all
    uint blended = 0u;
    uint behind = 0u;
    do {
        uint count = 0u;
        uint walked = 0u;
        for (uint number = first; number != 0u;) {
            uint place = fragment_place(number);
            uvec4 fragment = uvec4(
                fragments[place + 1u], fragments[place + 2u], fragments[place + 3u], number);
            number = fragments[place];
            if (!is_before(last, fragment)) continue;
            walked += 1u;
            if (count == SORTED && !is_before(fragment, nearest[SORTED - 1u])) continue;
            count = min(count + 1u, SORTED);
            uint at = count - 1u;
            while (at > 0u && is_before(fragment, nearest[at - 1u])) {
                nearest[at] = nearest[at - 1u];
                at -= 1u;
            }
            nearest[at] = fragment;
        }
        uint wanted = min(count, most - blended);
        for (uint at = 0u; at < wanted; ++at) {
            last = nearest[at];
            vec4 held = vec4(unpackUnorm2x16(last.y), unpackUnorm2x16(last.z));
            light += through * held.rgb;
            through *= 1.0 - held.a;
        }
        blended += wanted;
        behind = walked - wanted;
    } while (behind > 0u && blended < most && through > 0.0);
    // What is behind an opaque one is not missed.
    if (through > 0.0 && behind > 0u) atomicAdd(counts[2], behind);
    colour = vec4(light, 1.0 - through);
}
