// The draws that depend on a result, and the draws of boxes that precede a decision per leaf.

const uint REVEAL_DRAWS = 0;   // the draws of the range
const uint REVEAL_BOXES = 1;   // boxes, an instance each
const uint REVEAL_ENABLED = 2; // those draws of the range that fragments of boxes enabled

struct Decided {
    uint first;
    uint count;
    uint reveal;
    uint result;
};

struct BoxDraw {
    uint vertex_count;
    uint instance_count;
    uint first_vertex;
    uint first_instance;
};
