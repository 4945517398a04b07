// The second pipeline of the hosts: stripes of the colour of a box.
#version 460

layout(location = 0) flat in uint number;
layout(location = 1) in vec3 world;
layout(location = 0) out vec4 colour;

void main() {
    uvec3 bytes = (uvec3(number + 1) * 2654435761u >> uvec3(8, 16, 24)) & 255u;
    float stripe = fract(world.y * 8.0) < 0.5 ? 1.0 : 0.3;
    colour = vec4(vec3(bytes) / 255.0 * stripe, 1.0);
}
