// The opaque pass: one directional light, plain diffuse; sRGB is encoded by the attachment.
#include "opaque_constants.glsl"

layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec3 albedo;

#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

layout(location = 0) out vec4 colour;

void main() {
    vec3 n = normalize(world_normal);
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
    n = gl_FrontFacing ? n : -n;
#endif
    vec3 ambient = mix(ambient_below.rgb, ambient_above.rgb, 0.5 + 0.5 * n.y);
    vec3 direct = sun.rgb * max(dot(n, towards_sun.xyz), 0.0);
    colour = vec4(albedo * (ambient + direct), 1.0);
}
