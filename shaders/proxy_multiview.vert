// The proxy pass where several views are drawn at once: proxy.vert with the constants of each view.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "box.glsl"
#include "eye.glsl"
#include "instance_number.glsl"

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };
layout(std430, binding = 2) readonly buffer Eyes { Eye eyes[]; };

layout(location = 0) flat out uint test;

void main() {
    Box box = boxes[instance_number];
    Eye eye = eyes[gl_ViewIndex];
    test = instance_number;
    gl_Position = box_vertex(box.low.xyz, box.high.xyz, eye.eye, eye.view_proj, gl_VertexIndex);
}
