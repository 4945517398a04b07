// Edges: widens a line to a strip. A shader that includes this defines SECTION if lines are cut.
#include "edge_constants.glsl"
#include "edge_strip.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 8) out;

layout(location = 0) in vec3 line_from[];
layout(location = 1) in vec3 line_to[];
layout(location = 2) in vec2 line_along[];

layout(location = 0) out float along;
#ifdef SECTION
layout(location = 3) in vec2 line_rise[];
layout(location = 14) flat in uint line_state[];

layout(location = 1) out float rise;
layout(location = 14) flat out uint section_state;
#endif

void main() {
    Line line = Line(line_from[0], line_to[0], line_along[0], vec2(0.0));
#ifdef SECTION
    line.rise = line_rise[0];
#endif
    if (line.from == line.to) return;
    for (uint corner = 0; corner < STRIP_CORNERS; ++corner) {
        gl_Position = strip_corner(line, corner);
        along = strip_along(line, corner);
#ifdef SECTION
        rise = strip_rise(line, corner);
        section_state = line_state[0];
#endif
        EmitVertex();
    }
    EndPrimitive();
}
