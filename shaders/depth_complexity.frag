// The depth complexity pass: the counts of the layers pass as colours, over the whole view. sRGB is
// encoded by the attachment.
#version 460

layout(std430, binding = 0) readonly buffer Layers { uint layers[]; };

layout(push_constant) uniform Constants {
    uvec2 origin; // of the view in the image (pixels)
    uint width;   // of the view (pixels)
};

layout(location = 0) out vec4 colour;

// Of one layer, sRGB-encoded, in steps of eight bits. Those of several are added.
const uvec3 LAYER = uvec3(32, 8, 2);

void main() {
    uvec2 place = uvec2(gl_FragCoord.xy) - origin;
    uint count = min(layers[place.y * width + place.x], 255u);
    vec3 encoded = min(vec3(count * LAYER) / 255.0, vec3(1.0));
    vec3 light = pow((encoded + 0.055) / 1.055, vec3(2.4));
    colour = vec4(mix(light, encoded / 12.92, lessThanEqual(encoded, vec3(0.04045))), 1.0);
}
