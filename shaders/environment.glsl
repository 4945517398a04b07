// The light from all around, as `scene::Environment` holds it: levels of the square of an
// octahedron behind each other, with a border of a texel.

layout(binding = ENVIRONMENT_BINDING) uniform sampler3D environment;

const float GLOSSY_LEVELS = 6.0;
const float LEVELS = 7.0;

vec2 place_of(vec3 direction) {
    vec3 scaled = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-20);
    vec2 signs = vec2(scaled.x < 0.0 ? -1.0 : 1.0, scaled.z < 0.0 ? -1.0 : 1.0);
    return scaled.y < 0.0 ? (1.0 - abs(scaled.zx)) * signs : scaled.xz;
}

vec3 from_around(vec3 direction, float level) {
    vec3 size = vec3(textureSize(environment, 0));
    vec2 inside = (place_of(direction) * 0.5 + 0.5) * (size.xy - 2.0) + 1.0;
    return textureLod(environment, vec3(inside / size.xy, (level + 0.5) / LEVELS), 0.0).rgb;
}

vec3 matt_from_around(vec3 normal) {
    return from_around(normal, GLOSSY_LEVELS);
}

vec3 glossy_from_around(vec3 direction, float roughness) {
    return from_around(direction, clamp(roughness, 0.0, 1.0) * (GLOSSY_LEVELS - 1.0));
}

// The share of light from all around that a glossy surface mirrors: a factor of its specular colour
// and what is added (Karis, "Physically Based Shading on Mobile", 2014).
vec2 mirrored_share(float roughness, float n_v) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float edge = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    return vec2(-1.04, 1.04) * edge + r.zw;
}
