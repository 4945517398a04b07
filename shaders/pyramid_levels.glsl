// The layout of the levels of a depth pyramid in one buffer: rows without gaps, level after level.
// Each has half the texels of the one below, rounded up, so a texel covers 2x2 below, or those of
// them that exist.

uvec2 size_above(uvec2 size) {
    return (size + 1) / 2;
}

uint texels(uvec2 size) {
    return size.x * size.y;
}
