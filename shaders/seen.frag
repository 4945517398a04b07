// The seen pass: a fragment that passes the test against the finished depth owns a pixel.
#version 460

layout(early_fragment_tests) in;

layout(location = 0) flat in uint leaf;

layout(std430, binding = 1) writeonly buffer Seen { uint seen[]; };

void main() {
    seen[leaf] = 1;
}
