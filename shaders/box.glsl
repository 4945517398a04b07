// The front faces of a box seen from outside, made from nothing but its corners: 18 vertices.

struct Box {
    vec4 low;
    vec4 high;
};

// Two triangles over the unit square.
const vec2 square[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));

// Clip-space position of one vertex. A face that does not show shrinks to a point outside of the
// view. The eye is in homogeneous coordinates: that of an orthographic view is infinitely far away,
// its w is 0.
vec4 box_vertex(vec3 low, vec3 high, vec4 eye, mat4 view_proj, int vertex) {
    int axis = vertex / 6;
    vec2 corner = square[vertex % 6];
    // From outside, an axis shows its low face, its high face, or none.
    bool shows_low = eye[axis] < low[axis] * eye.w;
    bool shows_high = eye[axis] > high[axis] * eye.w;
    vec3 mixed;
    mixed[axis] = shows_high ? 1.0 : 0.0;
    mixed[(axis + 1) % 3] = corner.x;
    mixed[(axis + 2) % 3] = corner.y;
    vec3 world = vec3(mixed.x > 0.5 ? high.x : low.x, mixed.y > 0.5 ? high.y : low.y,
                      mixed.z > 0.5 ? high.z : low.z);
    return shows_low || shows_high ? view_proj * vec4(world, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
