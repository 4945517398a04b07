// The leaf-box pass: the front faces of the proxy of a leaf.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance_number.glsl"
#include "leaf_box.glsl"

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 eye;    // in homogeneous coordinates
    vec4 row_w;
    vec2 margin;
};

layout(location = 0) flat out uint leaf;

void main() {
    leaf = instance_number;
    gl_Position =
        leaf_box_vertex(boxes[instance_number], view_proj, eye, row_w, margin, gl_VertexIndex);
}
