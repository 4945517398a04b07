// The sky pass: the environment in the direction of each pixel; sRGB is encoded by the attachment.
#version 460
#extension GL_GOOGLE_include_directive : require
#define ENVIRONMENT_BINDING 0
#include "environment.glsl"
#include "tonemap.glsl"

layout(push_constant) uniform Constants {
    vec4 middle; // the ray through the middle of the image; w: factor of all light
    vec4 right;  // from there to the right edge; w: the left edge in pixels
    vec4 down;   // from there to the lower edge; w: the upper edge in pixels
    vec4 size;   // of the image in pixels
    vec4 disk;     // towards a sun or moon; w: the distance of its edge on the unit sphere
    vec4 radiance; // of that; w: the distance at which its edge begins to fade
};

layout(location = 0) out vec4 colour;

void main() {
    vec2 place = (gl_FragCoord.xy - vec2(right.w, down.w)) / size.xy * 2.0 - 1.0;
    vec3 direction = middle.xyz + right.xyz * place.x + down.xyz * place.y;
    vec3 light = from_around(direction, 0.0);
    float away = distance(normalize(direction), disk.xyz);
    if (away < disk.w) light += radiance.xyz * (1.0 - smoothstep(radiance.w, disk.w, away));
    light *= middle.w;
    colour = vec4(tone_mapped(min(light, vec3(65504.0))), 1.0);
}
