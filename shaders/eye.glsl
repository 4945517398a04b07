// The constants of proxies where several views are drawn at once: one entry per view.

struct Eye {
    mat4 view_proj;
    vec4 eye;    // in homogeneous coordinates
    vec4 row_w;  // the clip coordinate w of a point relative to the eye
    vec4 margin; // its first two: see leaf_box.glsl
};
