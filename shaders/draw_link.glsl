// The draws of a leaf as a list: each names the next.

// True if a leaf has any number of draws, of any number of instances. Else draw and leaf have the
// same number, there is one instance, and nothing reads the buffers of the lists.
layout(constant_id = 14) const bool LINKED = false;

// 0, which is also what fragments load that take no part: lavapipe follows a list for them, too.
const uint NO_DRAW = 0;

struct DrawLink {
    uint next;           // one more than the number of the next of the same leaf, or NO_DRAW
    uint instance_count; // once the draw is enabled
};
