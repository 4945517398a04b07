// The sky pass: the light of an environment in the direction of each pixel, out of a panorama with
// PANORAMA defined, else of a computed sky; sRGB is encoded by the attachment.
#include "tonemap.glsl"

layout(push_constant) uniform Constants {
    vec4 middle; // the ray through the middle of the image; w: factor of all light
    vec4 right;  // from there to the right edge; w: the left edge in pixels
    vec4 down;   // from there to the lower edge; w: the upper edge in pixels
    vec2 size;   // of the image in pixels
};

struct Sky {
    vec4 towards_sun;
    vec4 zenith;
    vec4 horizon;
    vec4 ground;
    vec4 glow;
    vec4 disk;     // towards a sun or moon; w: the distance of its edge on the unit sphere
    vec4 radiance; // of that; w: the distance at which its edge begins to fade
};

layout(std430, binding = 0) readonly buffer Skies { Sky skies[]; };

layout(location = 0) out vec4 colour;

#ifdef PANORAMA
layout(binding = 1) uniform sampler2DArray panorama;

const float PI = 3.14159265358979;

// The texels of the level whose texels are as large as pixels. `beside` is the direction of a pixel
// beside this one: derivatives have a jump behind the eye, where the picture's ends meet.
vec3 radiance_from(vec3 direction, vec3 beside) {
    float across = 0.5 + atan(direction.x, -direction.z) / (2.0 * PI);
    float down = atan(length(direction.xz), direction.y) / PI;
    float texels = distance(direction, beside) * float(textureSize(panorama, 0).x) / (2.0 * PI);
    return textureLod(panorama, vec3(across, down, 0.0), log2(max(texels, 1.0))).rgb;
}
#else
float fourth(float value) {
    return value * value * value * value;
}

// As `scene::Sky::radiance` has it.
vec3 radiance_from(vec3 direction, vec3 beside) {
    Sky sky = skies[0];
    float height = 1.0 - fourth(1.0 - max(direction.y, 0.0));
    float near = max(dot(direction, sky.towards_sun.xyz), 0.0);
    float eighth = fourth(near) * fourth(near);
    vec3 above = mix(sky.horizon.rgb, sky.zenith.rgb, height) + sky.glow.rgb * (0.6 * eighth + fourth(fourth(fourth(near))));
    float clear = 1.0 + min(direction.y, 0.0);
    float haze = fourth(clear) * clear;
    return max(mix(sky.ground.rgb, above, haze), vec3(0.0));
}
#endif

// Less than half of a step of an 8-bit value, another one for each pixel of a tile (Bayer, "An
// Optimum Method for Two-Level Rendition of Continuous-Tone Pictures", 1973).
float dither(uvec2 pixel) {
    uint x = pixel.x ^ pixel.y;
    uint y = pixel.y;
    uint rank = (x & 1u) << 5 | (y & 1u) << 4 | (x & 2u) << 2 | (y & 2u) << 1 | (x & 4u) >> 1 | (y & 4u) >> 2;
    return ((float(rank) + 0.5) / 64.0 - 0.5) / 255.0;
}

// Gradients would show the steps of 8-bit sRGB as bands. Black stays black: some devices (NVIDIA
// 580) round what is a little less than half a step up.
vec3 dithered(vec3 light, uvec2 pixel) {
    light = clamp(light, 0.0, 1.0);
    vec3 code = mix(1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, 12.92 * light, lessThan(light, vec3(0.0031308)));
    code = max(code + dither(pixel) * vec3(greaterThan(code, vec3(0.0))), vec3(0.0));
    return mix(pow((code + 0.055) / 1.055, vec3(2.4)), code / 12.92, lessThan(code, vec3(0.04045)));
}

void main() {
    vec2 pixel = gl_FragCoord.xy - vec2(right.w, down.w);
    vec2 place = pixel / size * 2.0 - 1.0;
    vec3 ray = middle.xyz + right.xyz * place.x + down.xyz * place.y;
    vec3 direction = normalize(ray);
    vec3 light = radiance_from(direction, normalize(ray + right.xyz * (2.0 / size.x)));
    Sky sky = skies[0];
    float away = distance(direction, sky.disk.xyz);
    if (away < sky.disk.w) light += sky.radiance.xyz * (1.0 - smoothstep(sky.radiance.w, sky.disk.w, away));
    light *= middle.w;
    colour = vec4(dithered(tone_mapped(min(light, vec3(65504.0))), uvec2(pixel)), 1.0);
}
