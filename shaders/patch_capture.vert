// Fetches a control point of a Bezier patch: 16 vertices per patch.
#version 460

// Sixteen indices of control points per patch.
layout(std430, binding = 0) readonly buffer Patches { uint patches[]; };
// Three coordinates per control point.
layout(std430, binding = 1) readonly buffer ControlPoints { float control_points[]; };

layout(location = 0) out vec3 place;

void main() {
    uint point = patches[gl_VertexIndex] * 3;
    place = vec3(control_points[point], control_points[point + 1], control_points[point + 2]);
}
