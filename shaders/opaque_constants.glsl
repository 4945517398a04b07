// The push constants of the opaque pass, 128 bytes: as many as every device has.

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 towards_sun; // w: steps of the sub-pixel grid from the middle of the image to its side
    vec4 sun;         // w: the same to its top
    vec4 ambient_above;
    vec4 ambient_below;
};
