// The leaf-box pass: a fragment that passes the depth test switches on the draws of its leaf; the
// first one also adds the leaf to the list that is read back.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_memory_scope_semantics : require
#include "draw_link.glsl"

layout(early_fragment_tests) in;

layout(location = 0) flat in uint leaf;

struct IndirectDraw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

layout(std430, binding = 1) buffer Draws { IndirectDraw draws[]; };

// The number of entries, then the entries.
layout(std430, binding = 2) buffer List { uint list[]; };

// One more than the first draw of each leaf, or NO_DRAW; and the next ones.
layout(std430, binding = 3) readonly buffer Firsts { uint firsts[]; };
layout(std430, binding = 4) readonly buffer Links { DrawLink links[]; };

const uint LISTED_LEAVES = 4095;

// Other fragments may set the same draw: one that reads an old zero exchanges once more.
void main() {
    uint place_of_first = LINKED ? firsts[leaf] : leaf + 1;
    if (place_of_first == NO_DRAW) {
        return;
    }
    uint first = place_of_first - 1;
    uint instances = LINKED ? links[first].instance_count : 1;
    if (atomicLoad(draws[first].instance_count, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed) != 0
        || atomicExchange(draws[first].instance_count, instances) != 0) {
        return;
    }
    if (LINKED) {
        // Atomic for the validation of synchronization alone, which takes a plain store for one to
        // the draws of other leaves that are read in the same rendering.
        for (uint next = links[first].next; next != NO_DRAW; next = links[next - 1].next) {
            atomicExchange(draws[next - 1].instance_count, links[next - 1].instance_count);
        }
    }
    uint place = atomicAdd(list[0], 1);
    if (place < LISTED_LEAVES) {
        list[1 + place] = leaf;
    }
}
