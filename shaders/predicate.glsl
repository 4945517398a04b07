// The draws that depend on a predicate, and the draws of boxes that precede a decision per draw.

struct Decided {
    uint first;
    uint count;
    uint per_leaf; // 1: the boxes of the range are drawn first, and decide draw by draw
    uint result;
};

struct BoxDraw {
    uint vertex_count;
    uint instance_count;
    uint first_vertex;
    uint first_instance;
};
