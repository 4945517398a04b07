// Edges, where there is no geometry stage: each vertex is a corner of a triangle of the strip of
// its segment, in the order in which a strip has them.
#include "instance.glsl"
#include "instance_number.glsl"
#include "edge_constants.glsl"
#include "edge_strip.glsl"
#include "edge_line.glsl"
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif

layout(location = 0) out float along;
#ifdef SECTION_BINDING
layout(location = 1) out float rise;
#endif

void main() {
#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
    uint vertex = uint(gl_VertexIndex);
    uint place = vertex % STRIP_VERTICES;
    uint triangle = place / 3u;
    uint turn = place % 3u;
    // Every other triangle of a strip is turned around.
    uint corner = triangle + (turn == 0u || (triangle & 1u) == 0u ? turn : 3u - turn);
    Line line = line_of(instances[instance_number], vertex / STRIP_VERTICES);
    gl_Position = strip_corner(line, corner);
    along = strip_along(line, corner);
#ifdef SECTION_BINDING
    rise = strip_rise(line, corner);
#endif
}
