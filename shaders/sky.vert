// The sky pass: one triangle over the whole image, farther than all things are.
#version 460

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0;
    // Depth is reversed: 0 is what the depth buffer holds where nothing was drawn.
    gl_Position = vec4(corner, 0.0, 1.0);
}
