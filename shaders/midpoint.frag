// The midpoint pass: depths halfway between the fronts and the backs of casters, as a light sees
// them. Depth is reversed, and 0 where nothing is.
#version 460

layout(binding = 0) uniform sampler2DArray fronts;
layout(binding = 1) uniform sampler2DArray backs;

layout(push_constant) uniform Constants {
    vec2 reach; // the most by which a front is moved: x + y * its depth
    int layer;
};

void main() {
    ivec3 texel = ivec3(gl_FragCoord.xy, layer);
    float front = texelFetch(fronts, texel, 0).r;
    float back = texelFetch(backs, texel, 0).r;
    // A back before the front, of an open mesh or of one around the light, is held as it is: a wall
    // stops light whichever side it shows.
    bool is_thick = back > 0.0 && back < front;
    float half_way = is_thick ? min(0.5 * (front - back), reach.x + reach.y * front) : 0.0;
    gl_FragDepth = max(front, back) - half_way;
}
