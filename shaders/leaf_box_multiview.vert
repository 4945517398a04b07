// The leaf-box pass where several views are drawn at once: leaf_box.vert with the constants of each
// view.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "instance_number.glsl"
#include "leaf_box.glsl"
#include "eye.glsl"

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };
layout(std430, binding = 5) readonly buffer Eyes { Eye eyes[]; };

layout(location = 0) flat out uint leaf;

void main() {
    Eye eye = eyes[gl_ViewIndex];
    leaf = instance_number;
    gl_Position = leaf_box_vertex(boxes[instance_number], eye.view_proj, eye.eye, eye.row_w,
                                  eye.margin.xy, gl_VertexIndex);
}
