// The first pipeline of the hosts: a colour per box.
#version 460

layout(location = 0) flat in uint number;
layout(location = 0) out vec4 colour;

void main() {
    uvec3 bytes = (uvec3(number + 1) * 2654435761u >> uvec3(8, 16, 24)) & 255u;
    colour = vec4(vec3(bytes) / 255.0, 1.0);
}
