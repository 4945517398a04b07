// The fragments of the transparent objects of a view, in a list per pixel. A shader that includes
// this defines FRAGMENTS_BINDING. All is in one buffer, so that one binding is enough:
//
//   head               FRAGMENTS_HEAD values, below
//   first of a list    a value per pixel of the view, rows from the top: a fragment, or 0 for none
//   fragments          from 1 on, four values each: the next one of the list or 0, its depth, and
//                      its colour, multiplied by alpha, in unorm16: red and green, blue and alpha
layout(std430, binding = FRAGMENTS_BINDING) buffer Fragments { uint fragments[]; };

const uint STORED = 0u;         // fragments so far, those without room included
const uint ORIGIN_X = 1u;       // of the view in the image (pixels)
const uint ORIGIN_Y = 2u;
const uint WIDTH = 3u;          // of the view (pixels)
const uint FIRST_FRAGMENT = 4u; // the place of fragment 1
const uint ROOM = 5u;           // fragments that there is room for
const uint BLENDED_MOST = 6u;   // the most that are blended at a pixel
const uint FRAGMENTS_HEAD = 8u;

// The place of the first of a pixel's list.
uint list_place() {
    uvec2 place = uvec2(gl_FragCoord.xy) - uvec2(fragments[ORIGIN_X], fragments[ORIGIN_Y]);
    return FRAGMENTS_HEAD + place.y * fragments[WIDTH] + place.x;
}

uint fragment_place(uint number) {
    return fragments[FIRST_FRAGMENT] + (number - 1u) * 4u;
}

// Adds a fragment to the list of its pixel. Its colour is one that the image can hold.
void store_fragment(vec4 colour) {
    vec4 held = clamp(colour, 0.0, 1.0);
    // It would change nothing.
    if (held.a == 0.0) return;
    uint number = atomicAdd(fragments[STORED], 1u) + 1u;
    if (number > fragments[ROOM]) return;
    vec3 multiplied = held.rgb * held.a;
    uint place = fragment_place(number);
    fragments[place + 1u] = floatBitsToUint(gl_FragCoord.z);
    fragments[place + 2u] = packUnorm2x16(multiplied.rg);
    fragments[place + 3u] = packUnorm2x16(vec2(multiplied.b, held.a));
    fragments[place] = atomicExchange(fragments[list_place()], number);
}
