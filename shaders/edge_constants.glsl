// The push constants of edges, 124 bytes. Places are relative to the anchor, places on the screen
// in pixels from the middle of the view.

layout(push_constant) uniform Constants {
    mat3x4 axes;      // clip coordinates per metre along the axes of the world
    vec4 anchor;      // in the world; w: its clip z, x and y are 0
    vec4 eye;         // in homogeneous coordinates: w is 0 for the direction towards a parallel eye
    vec2 half_size;   // of the view
    float half_width; // of a line
    float anchor_w;   // clip w of the anchor
    vec3 colour;      // linear
    float dash;       // length of a dash; 0 for lines without gaps
    vec2 depth_step;  // the depth of a pixel's width along the view: factor of the depth, and a sum
    float period;     // length of a dash and its gap
};

mat4 view_proj() {
    return mat4(axes[0], axes[1], axes[2], vec4(0.0, 0.0, anchor.w, anchor_w));
}
