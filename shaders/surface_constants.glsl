// The constants of all draws of one surface pass: the view and the ambient light in 128 bytes of
// push constants, and the features that the scene uses, for which pipelines are compiled.

layout(push_constant) uniform Constants {
    mat4 view_proj;     // of places relative to the anchor
    vec3 anchor;        // the place in the world that others are relative to: in perspective the eye
    float exposure;
    vec3 towards_eye;   // where rays are parallel, else 0
    uint shadow_view;   // the number of this view among those that a directional light has maps for
    vec4 ambient_above; // w: steps of the sub-pixel grid from the middle of the image to its side
    vec4 ambient_below; // w: the same to its top
};

layout(constant_id = 0) const bool MASKED = false;
layout(constant_id = 1) const bool BLENDED = false;
layout(constant_id = 2) const bool UNLIT = false;
layout(constant_id = 3) const bool EMISSIVE = false;
layout(constant_id = 4) const bool TRANSFORMED = false;
layout(constant_id = 5) const uint DIRECTIONAL_LIGHTS = 0;
layout(constant_id = 6) const bool LOCAL_LIGHTS = false;
layout(constant_id = 7) const bool SPOTS = false;
// One bit for each page that some material's texture of this kind lies on.
layout(constant_id = 8) const uint BASE_COLOUR_PAGES = 0;
layout(constant_id = 9) const uint METALLIC_ROUGHNESS_PAGES = 0;
layout(constant_id = 10) const uint NORMAL_PAGES = 0;
layout(constant_id = 11) const uint OCCLUSION_PAGES = 0;
layout(constant_id = 12) const uint EMISSION_PAGES = 0;
// The same for the pictures that spots project.
layout(constant_id = 16) const uint PICTURE_PAGES = 0;
// True if the ambient light comes from `environment.glsl`.
layout(constant_id = 15) const bool ENVIRONMENT = false;
// True if pixels have several samples. A triangle may then cover a pixel without its middle, so
// what vertices give is taken at the centroid: in the middle it would be that of the plane beyond
// the triangle's edge. Centroids are not evenly spaced: derivatives are of values in the middles.
layout(constant_id = 17) const bool SEVERAL_SAMPLES = false;
// One of the filters of `shadows.glsl`.
layout(constant_id = 14) const uint SHADOW_FILTER = 0;
