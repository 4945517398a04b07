// The front faces of the proxy of a leaf, enlarged here as `cull::Margin` does it.
#include "box.glsl"

// The error of rounding that differs from the CPU's, as a share of the distance.
const float CAUTION = 1.0 + 1.0 / 65536.0;

// Clip-space position of one vertex. `row_w` is the clip coordinate w of a point relative to the
// eye; `margin` is how far a proxy reaches beyond its box where w is 1, and anywhere, in metres.
vec4 leaf_box_vertex(Box box, mat4 view_proj, vec4 eye, vec4 row_w, vec2 margin, int vertex) {
    // A leaf without an object has a box turned inside out: it is drawn nowhere.
    if (box.low.x > box.high.x) {
        return vec4(2.0, 2.0, 0.0, 1.0);
    }
    vec3 centre = 0.5 * (box.low.xyz + box.high.xyz);
    vec3 half_extent = 0.5 * (box.high.xyz - box.low.xyz);
    // At the farthest corner.
    float w = dot(row_w.xyz, centre - eye.xyz) + row_w.w + dot(abs(row_w.xyz), half_extent);
    vec3 largest = max(abs(box.low.xyz), abs(box.high.xyz));
    // 32 times the rounding of a coordinate, as on the CPU.
    float slack = max(3.8146973e-6 * max(largest.x, max(largest.y, largest.z)), margin.y);
    float distance = CAUTION * (margin.x * w + slack);
    return box_vertex(box.low.xyz - distance, box.high.xyz + distance, eye, view_proj, vertex);
}
