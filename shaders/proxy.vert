// The proxy pass: the front faces of enlarged boxes. Without a fragment shader only the depth test
// and the occlusion query look at them; with proxy.frag each sets a flag.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "box.glsl"
#include "instance_number.glsl"

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 eye; // in homogeneous coordinates
};

layout(location = 0) flat out uint test;

void main() {
    Box box = boxes[instance_number];
    test = instance_number;
    gl_Position = box_vertex(box.low.xyz, box.high.xyz, eye, view_proj, gl_VertexIndex);
}
