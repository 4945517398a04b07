// A line on the screen as a strip of eight corners: its body, and a square cap at either end, so
// that corners of lines have no gaps. Caps are as deep as the end that they continue. Includes need
// edge_constants.glsl.

// A line, or none if its ends are the same.
struct Line {
    vec3 from;  // in pixels; z: depth
    vec3 to;
    vec2 along; // the place of its ends in the pattern of dashes
    vec2 rise;  // the depth by which its ends are nearer than the edge
};

const uint STRIP_CORNERS = 8;
// The corners of its triangles, one after the other.
const uint STRIP_VERTICES = 18;

// Returns a corner's place in clip space, in pairs from one end to the other.
vec4 strip_corner(Line line, uint corner) {
    precise vec2 reach = line.to.xy - line.from.xy;
    precise float length_px = sqrt(reach.x * reach.x + reach.y * reach.y);
    precise vec2 direction = reach / max(length_px, 1.0e-6);
    precise vec2 aside = vec2(-direction.y, direction.x) * ((corner & 1u) == 0u ? half_width : -half_width);
    uint pair = corner / 2u;
    precise vec2 beyond = direction * (pair == 0u ? -half_width : pair == 3u ? half_width : 0.0);
    vec3 end = pair < 2u ? line.from : line.to;
    precise vec2 place = (end.xy + beyond + aside) / half_size;
    return length_px > 0.0 ? vec4(place, end.z, 1.0) : vec4(-2.0, -2.0, 0.0, 1.0);
}

// Returns the depth by which a corner is nearer than the edge.
float strip_rise(Line line, uint corner) {
    return corner / 2u < 2u ? line.rise.x : line.rise.y;
}

// Returns a corner's place in the pattern of dashes.
float strip_along(Line line, uint corner) {
    precise vec2 reach = line.to.xy - line.from.xy;
    precise float length_px = sqrt(reach.x * reach.x + reach.y * reach.y);
    precise float rate = (line.along.y - line.along.x) / max(length_px, 1.0e-6);
    uint pair = corner / 2u;
    precise float beyond = pair == 0u ? -half_width * rate : pair == 3u ? half_width * rate : 0.0;
    precise float along = (pair < 2u ? line.along.x : line.along.y) + beyond;
    return along;
}
