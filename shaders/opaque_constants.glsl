// The push constants of the opaque pass, 128 bytes: as many as every device has.

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 towards_sun;
    vec4 sun;
    vec4 ambient_above;
    vec4 ambient_below;
};
