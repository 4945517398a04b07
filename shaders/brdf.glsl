// The metallic-roughness model of glTF 2.0, appendix B: a metal's BRDF (GGX, tinted) and a
// dielectric's (Lambert below, GGX above, mixed by Schlick's Fresnel term), mixed by the surface's
// metalness. Both share the GGX term, so their Fresnel terms mix; the light that a dielectric lets
// through is its own.

const float PI = 3.14159265358979;
// The reflectance of a dielectric of index 1.5 at normal incidence.
const float DIELECTRIC = 0.04;

// A material at one point of a surface, seen from one direction.
struct Brdf {
    vec3 diffuse;  // c_diff
    vec3 specular; // f0
    float squared; // of alpha, which is roughness squared
    float masked;  // what the eye's angle adds to the denominator of GGX's visibility
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
    float alpha = max(roughness * roughness, 0.001);
    float squared = alpha * alpha;
    float n_v = abs(dot(normal, towards_eye));
    float masked = n_v + sqrt(squared + (1.0 - squared) * n_v * n_v);
    return Brdf(diffuse, specular, squared, masked, normal, towards_eye);
}

// The part of the light from one direction that goes to the eye, the cosine included.
vec3 reflected(Brdf brdf, vec3 towards_light) {
    float n_l = dot(brdf.normal, towards_light);
    if (n_l <= 0.0) return vec3(0.0);
    // H is along L + V, whose length is twice V.H.
    vec3 sum = towards_light + brdf.towards_eye;
    float length_squared = max(dot(sum, sum), 1e-12);
    float n_sum = dot(brdf.normal, sum);
    // (N.H)^2 (alpha^2 - 1) + 1 is alpha^2 (N.H)^2 + |N x H|^2, which does not cancel in
    // highlights.
    vec3 across = cross(brdf.normal, sum);
    float lobe = (brdf.squared * n_sum * n_sum + dot(across, across)) / length_squared;
    // D times G / (4 |N.L| |N.V|), in one division; both cosines with H are positive where D is not
    // 0.
    float shadowed = n_l + sqrt(brdf.squared + (1.0 - brdf.squared) * n_l * n_l);
    float glossy = n_sum > 0.0 ? brdf.squared / (PI * lobe * lobe * shadowed * brdf.masked) : 0.0;
    float rest = max(1.0 - 0.5 * sqrt(length_squared), 0.0);
    float grazing = rest * rest * rest * rest * rest;
    vec3 fresnel = brdf.specular + (1.0 - brdf.specular) * grazing;
    vec3 diffuse = brdf.diffuse * ((1.0 - DIELECTRIC) * (1.0 - grazing) / PI);
    return (diffuse + fresnel * glossy) * n_l;
}
