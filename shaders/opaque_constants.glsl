// The push constants of the opaque pass, 128 bytes: as many as every device has.

layout(push_constant) uniform Constants {
    mat3x4 axes;        // clip coordinates per metre along the axes of the world
    vec4 anchor;        // the place that others are relative to; w: its clip z
    vec4 towards_sun;   // w: steps of the sub-pixel grid from the middle of the image to its side
    vec4 sun;           // w: the same to its top
    vec4 ambient_above; // w: clip w of the anchor
    // w: clip x and y of the anchor, 0. It is no constant of the shader: compilers might multiply
    // otherwise by one, and the surface pass must find the same depth, to the bit.
    vec4 ambient_below;
};
