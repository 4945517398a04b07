// The proxy pass with flags: a fragment that passes the depth test says that its box shows.
#version 460

layout(early_fragment_tests) in;

layout(location = 0) flat in uint test;

layout(std430, binding = 1) writeonly buffer Flags { uint flags[]; };

void main() {
    flags[test] = 1;
}
