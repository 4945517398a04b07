// What hangs on a word, and the draws of boxes that go before a decision draw by draw.

struct Decided {
    uint first;
    uint count;
    uint parts; // 1: the boxes of the range are drawn first, and decide draw by draw
    uint word;
};

struct BoxDraw {
    uint vertex_count;
    uint instance_count;
    uint first_vertex;
    uint first_instance;
};
