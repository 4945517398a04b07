// The surface pass: metallic-roughness materials under punctual lights and a hemisphere of ambient
// light; sRGB is encoded by the attachment. With SHADOWED defined, lights have shadow maps; with
// VOLUMES, a mask of shadow volumes. With FRAGMENTS_BINDING, colours are not drawn but stored, to
// be sorted.
#include "material.glsl"
#include "surface_constants.glsl"
#include "texels.glsl"
#include "surface_alpha.glsl"
#include "brdf.glsl"
#include "lights.glsl"
#include "light_cookie.glsl"
#include "environment.glsl"
#include "tonemap.glsl"
#ifdef SECTION_BINDING
#include "section_fragment.glsl"
#endif

layout(location = 4) flat in uvec4 material_emission;
layout(location = 5) flat in uvec4 material_details;
layout(location = 6) centroid in vec3 covered_position; // relative to the anchor
layout(location = 7) centroid in vec3 world_normal;
layout(location = 8) centroid in vec4 world_tangent; // w: sign of the bitangent
layout(location = 9) flat in uvec2 lights_of_object; // slot of the list, how many

layout(location = 11) in vec3 middle_position; // in the middle of the pixel

#ifdef FRAGMENTS_BINDING
#include "fragments.glsl"
layout(early_fragment_tests) in;

vec4 colour;
#else
layout(location = 0) out vec4 colour;
#endif

// The place that is shaded, relative to the anchor; at first that of the middle of the pixel, for
// derivatives.
vec3 world_position;

// The normal that is seen: the surface's own, or that of its texture in tangent space.
vec3 shading_normal(vec4 uvs) {
    vec3 n = unit_or(world_normal, vec3(0.0, 1.0, 0.0));
    if (NORMAL_PAGES == 0u || !has_texture(material_details.x)) return n;
    vec3 mapped = texel(NORMAL_PAGES, material_details.x, uvs).xyz * 2.0 - 1.0;
    if ((material_factors.w & NORMALS_OF_TWO_CHANNELS_FLAG) != 0u)
        mapped.z = sqrt(max(1.0 - dot(mapped.xy, mapped.xy), 0.0));
    mapped.xy *= uintBitsToFloat(material_cuts.y);
    vec3 t = unit_or(world_tangent.xyz, vec3(0.0));
    vec3 b = cross(n, t) * world_tangent.w;
    return unit_or(mapped.x * t + mapped.y * b + mapped.z * n, n);
}

// The ambient light: that of the environment, or the hemisphere on the diffuse part, and, where it
// is mirrored, on the specular one; rougher surfaces mirror more of what is around their normal.
vec3 ambient(Brdf brdf, float roughness) {
    if (ENVIRONMENT) {
        float n_v = abs(dot(brdf.normal, brdf.towards_eye));
        vec2 share = mirrored_share(roughness, n_v);
        vec3 around = glossy_from_around(reflect(-brdf.towards_eye, brdf.normal), roughness);
        vec3 mirrored = around * (brdf.specular * share.x + share.y);
        return brdf.diffuse * matt_from_around(brdf.normal) + mirrored;
    }
    float mirrored = reflect(-brdf.towards_eye, brdf.normal).y;
    float specular_up = mix(mirrored, brdf.normal.y, roughness);
    vec3 on_diffuse = mix(ambient_below.rgb, ambient_above.rgb, 0.5 + 0.5 * brdf.normal.y);
    vec3 on_specular = mix(ambient_below.rgb, ambient_above.rgb, 0.5 + 0.5 * specular_up);
    return brdf.diffuse * on_diffuse + brdf.specular * on_specular;
}

#ifdef SHADOWED
#include "shadows.glsl"
// The normal of the triangle.
vec3 facet;
#endif
#ifdef VOLUMES
#include "volume_shadows.glsl"
#endif

// The light of the lamps of the object's list. Each pixel looks for its next lamp before any is
// shaded: drivers that mask branches instead of skipping them would else shade a pixel, with all
// samples of its shadows, by lamps that do not reach it.
vec3 from_lamps(Brdf brdf) {
    vec3 sum = vec3(0.0);
    uint place = 0u;
    while (true) {
        uint number = 0u;
        vec3 away = vec3(0.0);
        vec3 towards = vec3(0.0);
        vec3 arrived = vec3(0.0);
        while (arrived == vec3(0.0) && place < lights_of_object.y) {
            number = light_of_list(lights_of_object.x, place);
            place += 1u;
            away = (lights[number].position.xyz - anchor) - world_position;
            // Nearer than a millimetre is as a millimetre.
            float squared = max(dot(away, away), 1e-6);
            float inverse_distance = inversesqrt(squared);
            towards = away * inverse_distance;
            if (dot(brdf.normal, towards) > 0.0) {
                arrived = arriving(lights[number], towards, squared, inverse_distance);
            }
        }
        if (arrived == vec3(0.0)) return sum;
        arrived *= reflected(brdf, towards);
        if (PICTURE_PAGES != 0u) arrived *= picture_colour(lights[number], -away);
#ifdef SHADOWED
        arrived *= lit(number, away, facet);
#endif
#ifdef VOLUMES
        arrived *= unshadowed(number);
#endif
        sum += arrived;
    }
    return sum;
}

vec3 direct(Brdf brdf) {
    vec3 sum = vec3(0.0);
    for (uint number = 0; number < DIRECTIONAL_LIGHTS; ++number) {
        PunctualLight light = lights[number];
        vec3 arrived = light.intensity.rgb * reflected(brdf, -light.direction.xyz);
#ifdef SHADOWED
        if (arrived != vec3(0.0)) arrived *= sunlit(number, facet);
#endif
#ifdef VOLUMES
        if (arrived != vec3(0.0)) arrived *= unshadowed(number);
#endif
        sum += arrived;
    }
    if (LOCAL_LIGHTS) sum += from_lamps(brdf);
    return sum;
}

void main() {
    world_position = SEVERAL_SAMPLES ? middle_position : covered_position;
#ifdef SHADOWED
    // Before anything is discarded: derivatives are defined here.
    facet = facet_normal();
#endif
    if (PICTURE_PAGES != 0u) {
        picture_step_x = dFdx(world_position);
        picture_step_y = dFdy(world_position);
    }
    world_position = at_centroid(vec4(covered_position, 0.0)).xyz;
    vec4 uvs = at_centroid(covered_uvs);
    vec4 base = base_colour();
    float alpha = BLENDED ? clamp(base.a, 0.0, 1.0) : 1.0;

    vec2 roughness_metallic = unpackUnorm2x16(material_factors.z);
    if (METALLIC_ROUGHNESS_PAGES != 0u) {
        roughness_metallic *= texel(METALLIC_ROUGHNESS_PAGES, material_cuts.w, uvs).gb;
    }
    float occlusion = 1.0;
    if (OCCLUSION_PAGES != 0u) {
        float strength = unpackUnorm2x16(material_factors.w).x;
        occlusion += strength * (texel(OCCLUSION_PAGES, material_details.y, uvs).r - 1.0);
    }
    vec3 emission = vec3(0.0);
    if (EMISSIVE) {
        emission = uintBitsToFloat(material_emission.xyz);
        if (EMISSION_PAGES != 0u) emission *= texel(EMISSION_PAGES, material_emission.w, uvs).rgb;
    }
    vec3 n = shading_normal(uvs);
    // Not before the last texel: where a neighbour is gone, derivatives are not defined.
    if (MASKED && is_hole(base)) discard;
#ifdef SECTION_BINDING
    if (is_cut_away(section_state)) discard;
    n = gl_FrontFacing ? n : -n;
#endif
    vec3 v = unit_or(towards_eye == vec3(0.0) ? -world_position : towards_eye, n);
    Brdf brdf = brdf_of(base.rgb, roughness_metallic.y, roughness_metallic.x, n, v);
    vec3 light = ambient(brdf, roughness_metallic.x) * occlusion + direct(brdf) + emission;
    colour = vec4(tone_mapped(min(light * exposure, vec3(65504.0))), alpha);
    // An unlit surface is its base colour: neither lit nor exposed, so not mapped either.
    if (UNLIT && (material_factors.w & UNLIT_FLAG) != 0u) colour.rgb = base.rgb;
#ifdef FRAGMENTS_BINDING
    store_fragment(colour);
#endif
}
