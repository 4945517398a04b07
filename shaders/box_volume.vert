// The proxies of casters: the shadow volume of an enlarged box, which is the hull of the box drawn
// towards the light and of the box drawn away from it. 108 vertices: the six faces, then the twelve
// edges. A face that the light sees is one of the near end, any other one of the far end; an edge
// between two such faces spans a side from end to end, any other edge shrinks to a point.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance_number.glsl"

struct BoxVolume {
    vec3 low;
    float towards;
    vec3 high;
    float away;
};

layout(std430, binding = 0) readonly buffer Boxes { BoxVolume boxes[]; };

layout(push_constant) uniform Constants {
    mat4 view_proj;
    vec4 light; // in homogeneous coordinates
};

layout(location = 0) flat out uint test;

// Two triangles over the unit square.
const vec2 square[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));

bool is_lit(BoxVolume box, int axis, bool is_high) {
    return is_high ? light[axis] > box.high[axis] * light.w : light[axis] < box.low[axis] * light.w;
}

vec4 drawn(BoxVolume box, vec3 corner, bool is_far) {
    vec3 place = mix(box.low, box.high, corner);
    float k = is_far ? box.away : -box.towards;
    return view_proj * vec4(place + k * (place * light.w - light.xyz), 1.0);
}

void main() {
    BoxVolume box = boxes[instance_number];
    test = instance_number;
    vec2 at = square[gl_VertexIndex % 6];
    int part = gl_VertexIndex / 6;
    vec3 corner;
    if (part < 6) {
        int axis = part / 2;
        corner[axis] = float(part % 2);
        corner[(axis + 1) % 3] = at.x;
        corner[(axis + 2) % 3] = at.y;
        gl_Position = drawn(box, corner, !is_lit(box, axis, part % 2 == 1));
        return;
    }
    int axis = (part - 6) / 4;
    int beside = (axis + 1) % 3;
    int beyond = (axis + 2) % 3;
    bool is_high_beside = (part - 6) % 2 == 1;
    bool is_high_beyond = (part - 6) % 4 >= 2;
    corner[axis] = at.x;
    corner[beside] = is_high_beside ? 1.0 : 0.0;
    corner[beyond] = is_high_beyond ? 1.0 : 0.0;
    bool is_side = is_lit(box, beside, is_high_beside) != is_lit(box, beyond, is_high_beyond);
    gl_Position = is_side ? drawn(box, corner, at.y > 0.5) : vec4(2.0, 2.0, 0.0, 1.0);
}
