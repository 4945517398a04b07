// The proxy pass: the front faces of an enlarged box, made from nothing but its corners.
// There is no fragment shader: only the depth test and the occlusion query look at it.
#version 460

struct Box {
    vec4 low;
    vec4 high;
};

layout(std430, binding = 0) readonly buffer Boxes { Box boxes[]; };

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 eye;
};

// Two triangles over the unit square.
const vec2 corners[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));

void main() {
    Box box = boxes[gl_InstanceIndex];
    int axis = gl_VertexIndex / 6;
    vec2 corner = corners[gl_VertexIndex % 6];
    // From outside, an axis shows its low face, its high face, or none.
    bool shows_low = eye[axis] < box.low[axis];
    bool shows_high = eye[axis] > box.high[axis];
    vec3 mixed;
    mixed[axis] = shows_high ? 1.0 : 0.0;
    mixed[(axis + 1) % 3] = corner.x;
    mixed[(axis + 2) % 3] = corner.y;
    vec3 world = vec3(mixed.x > 0.5 ? box.high.x : box.low.x,
                      mixed.y > 0.5 ? box.high.y : box.low.y,
                      mixed.z > 0.5 ? box.high.z : box.low.z);
    // A face that does not show shrinks to a point outside of the view.
    gl_Position = shows_low || shows_high ? view_proj * vec4(world, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
