// Shadow volumes: vertices that a compute pass has extruded.
#version 460

layout(location = 0) in vec4 clip;

invariant gl_Position;

void main() {
    gl_Position = clip;
}
