// The opaque pass: one directional light, plain diffuse; sRGB is encoded by the attachment.
#version 460

layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec3 albedo;

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 towards_light;
    vec4 ambient; // from below in w: how much less light comes from the ground
};

layout(location = 0) out vec4 colour;

void main() {
    vec3 n = normalize(world_normal);
    float direct = max(dot(n, towards_light.xyz), 0.0) * towards_light.w;
    vec3 sky = ambient.rgb * mix(ambient.w, 1.0, 0.5 + 0.5 * n.y);
    colour = vec4(albedo * (sky + direct), 1.0);
}
