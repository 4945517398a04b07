// The blocks of lens flares: squares of pixels at the places and depths of lights.

struct FlareBlock {
    ivec2 low;        // upper left corner in the image of the view
    ivec2 target_low; // the same in the target
    uint side;
    float depth;
    uint first_cell;  // the number of its first pixel among those of all blocks
    uint unused;
};

// How much transparent objects take is added up as the logarithm of what they let through: a sum
// has no order. So many steps halve the light.
const float STEPS_PER_HALVING = 65536.0;
