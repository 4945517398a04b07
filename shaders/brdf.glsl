// The metallic-roughness model of glTF 2.0, appendix B: a metal's BRDF (GGX, tinted) and a dielectric's
// (Lambert below, GGX above, mixed by Schlick's Fresnel term), mixed by how metallic a surface is. Both
// share the GGX term, so their Fresnel terms mix; the light that a dielectric lets through is its own.

const float PI = 3.14159265358979;
// What a dielectric of index 1.5 mirrors of what meets it head on.
const float DIELECTRIC = 0.04;

// A material at one point of a surface, seen from one direction.
struct Brdf {
    vec3 diffuse;  // c_diff
    vec3 specular; // f0
    float alpha;   // roughness squared
    vec3 normal;
    vec3 towards_eye;
};

vec3 unit_or(vec3 v, vec3 otherwise) {
    float squared = dot(v, v);
    return squared > 1e-20 ? v * inversesqrt(squared) : otherwise;
}

// Perfect mirrors would show point lights as points: alpha is at least 0.001, a roughness of 0.032.
Brdf brdf_of(vec3 base_colour, float metallic, float roughness, vec3 normal, vec3 towards_eye) {
    vec3 diffuse = mix(base_colour, vec3(0.0), metallic);
    vec3 specular = mix(vec3(DIELECTRIC), base_colour, metallic);
    return Brdf(diffuse, specular, max(roughness * roughness, 0.001), normal, towards_eye);
}

// What of the light from one direction goes to the eye, the cosine included.
vec3 reflected(Brdf brdf, vec3 towards_light) {
    float n_l = dot(brdf.normal, towards_light);
    if (n_l <= 0.0) return vec3(0.0);
    vec3 h = unit_or(towards_light + brdf.towards_eye, brdf.normal);
    float n_h = dot(brdf.normal, h);
    float n_v = abs(dot(brdf.normal, brdf.towards_eye));
    float v_h = clamp(dot(brdf.towards_eye, h), 0.0, 1.0);
    float squared = brdf.alpha * brdf.alpha;

    // (N.H)^2 (alpha^2 - 1) + 1 is alpha^2 (N.H)^2 + |N x H|^2, which does not cancel in highlights.
    vec3 across = cross(brdf.normal, h);
    float lobe = squared * n_h * n_h + dot(across, across);
    float d = n_h > 0.0 ? squared / (PI * lobe * lobe) : 0.0;
    // G / (4 |N.L| |N.V|); both cosines with H are positive where D is not 0.
    float shadowed = n_l + sqrt(squared + (1.0 - squared) * n_l * n_l);
    float masked = n_v + sqrt(squared + (1.0 - squared) * n_v * n_v);
    float rest = 1.0 - v_h;
    float grazing = rest * rest * rest * rest * rest;
    vec3 fresnel = brdf.specular + (1.0 - brdf.specular) * grazing;
    vec3 diffuse = brdf.diffuse * ((1.0 - DIELECTRIC) * (1.0 - grazing) / PI);
    return (diffuse + fresnel * (d / (shadowed * masked))) * n_l;
}
