// The ranges of draws that the lists of a frame are made of.

const uint SOURCE_QUERIES = 0;
const uint SOURCE_FRAGMENTS = 1;
const uint SOURCE_COMPUTE = 2;

struct ListedRange {
    uint first;         // of its commands among all draws of the scene
    uint count;
    uint source;        // of the result that decides
    uint result;
    uint is_enabled;    // 1: of the copy of all draws whose instances fragments of boxes set
    uint list;
    uint first_of_list; // the first range of the same list; ranges of a list follow each other
    uint first_command; // of the list, among the commands of all lists
};

struct IndirectDraw {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

struct RangeSize {
    uint drawn;  // the commands of the range that are drawn
    uint before; // those of all ranges before it, whatever their list
};
