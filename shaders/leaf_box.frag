// The leaf-box pass: a fragment that passes the depth test switches on the draw of its leaf; the
// first one also adds it to the list that is read back.
#version 460

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

const uint LISTED_DRAWS = 4095;

// Other fragments may set the same draw: one that reads an old zero exchanges once more.
void main() {
    if (draws[leaf].instance_count != 0 || atomicExchange(draws[leaf].instance_count, 1) != 0) {
        return;
    }
    uint place = atomicAdd(list[0], 1);
    if (place < LISTED_DRAWS) {
        list[1 + place] = leaf;
    }
}
