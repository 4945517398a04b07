// Finds the farthest depth in every cell of 8x8 pixels: the smallest, of depths that are turned
// around where they are not reversed.
#version 460

layout(local_size_x = 64) in;

const uint CELL = 8;

layout(std430, binding = 0) readonly buffer Depths { float depths[]; };
layout(std430, binding = 1) writeonly buffer Grid { float grid[]; };

layout(push_constant) uniform Constants {
    uvec2 size;
    float sign; // 1 where depth is reversed, else -1
};

void main() {
    uvec2 cells = (size + CELL - 1) / CELL;
    uint cell = gl_GlobalInvocationID.x;
    if (cell >= cells.x * cells.y) {
        return;
    }
    uvec2 first = uvec2(cell % cells.x, cell / cells.x) * CELL;
    // Beyond the edge the last pixels repeat, which changes no minimum: loops of a fixed length are
    // twice as fast where a CPU runs them.
    float farthest = 1.0;
    for (uint y = 0; y < CELL; ++y) {
        uint row = min(first.y + y, size.y - 1) * size.x;
        for (uint x = 0; x < CELL; ++x) {
            farthest = min(farthest, sign * depths[row + min(first.x + x, size.x - 1)]);
        }
    }
    grid[cell] = farthest;
}
