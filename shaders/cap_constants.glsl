// The constants and buffers of the cap pass: it counts an object's faces behind a section plane,
// and then draws the plane where the count is odd.

struct Cap {
    // Of (pixels right and down of the middle, depth, 1) in the plane, all times w: coordinates in
    // the object's box, from -1 to 1; w itself; the place across the lines of the hatch.
    vec4 box[3];
    vec4 w;
    vec4 hatch;
    vec4 colour; // linear; w unused
    vec4 area;   // the part of the view that the object may cover, in normalised device coordinates
    uvec4 tail;  // the plane, the state of the object, its leaf; the rest is 0
};

layout(push_constant) uniform Constants {
    mat4 view_proj; // of places relative to the anchor
    vec4 anchor;    // w unused
    vec2 snap_steps;
    uint cap_number;
};

layout(std430, binding = 1) readonly buffer Caps { Cap caps[]; };
