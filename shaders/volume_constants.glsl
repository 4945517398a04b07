// The push constants of shadow volumes, 124 bytes.

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 light;     // in homogeneous coordinates: w is 0 for the direction towards a sun
    vec4 end;       // the factor by which the light is taken off a corner, linear in the corner
    vec2 steps;     // of the sub-pixel grid from the middle of the image to its edges
    vec2 cap_depth; // factor of a near cap's depth, and what is taken off it
    uint is_robust; // 1: every triangle is extruded, as if it faced the light
    uint caps;      // NO_CAPS, NEAR_CAPS or BOTH_CAPS
    float far_w;    // of the points at the far end of a sun's volumes: 0 for infinity
};

const uint NO_CAPS = 0;
const uint NEAR_CAPS = 1;
const uint BOTH_CAPS = 2;
