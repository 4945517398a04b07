// The push constants of shadow volumes, 128 bytes. Places are relative to the anchor.

layout(push_constant) uniform Constants {
    mat3x4 axes;    // clip coordinates per metre along the axes of the world
    vec4 anchor;    // in the world; w: its clip z, x and y are 0
    vec4 light;     // in homogeneous coordinates: w is 0 for the direction towards a sun
    vec4 end;       // the factor by which the light is taken off a corner, linear in the corner
    vec2 steps;     // of the sub-pixel grid from the middle of the image to its edges
    vec2 cap_depth; // factor of a near cap's depth, and what is taken off it
    uint is_robust; // 1: every triangle is extruded, as if it faced the light
    uint caps;      // NO_CAPS, NEAR_CAPS or BOTH_CAPS
    float far_w;    // of the points at the far end of a sun's volumes: 0 for infinity
    float anchor_w; // clip w of the anchor
};

mat4 view_proj() {
    return mat4(axes[0], axes[1], axes[2], vec4(0.0, 0.0, anchor.w, anchor_w));
}

const uint NO_CAPS = 0;
const uint NEAR_CAPS = 1;
const uint BOTH_CAPS = 2;
