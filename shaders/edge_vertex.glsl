// Edges: the line of a segment, for the geometry stage.
#include "instance.glsl"
#include "instance_number.glsl"
#include "edge_constants.glsl"
#include "edge_strip.glsl"
#include "edge_line.glsl"
#ifdef SECTION_BINDING
#include "section_vertex.glsl"
#endif

layout(location = 0) out vec3 line_from;
layout(location = 1) out vec3 line_to;
layout(location = 2) out vec2 line_along;
#ifdef SECTION_BINDING
layout(location = 3) out vec2 line_rise;
#endif

void main() {
#ifdef SECTION_BINDING
    section_state = state_of(instance_number);
#endif
    Line line = line_of(instances[instance_number], uint(gl_VertexIndex));
    line_from = line.from;
    line_to = line.to;
    line_along = line.along;
#ifdef SECTION_BINDING
    line_rise = line.rise;
#endif
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}
