// The data of an object for vertex shaders: one entry per leaf, in depth-first order of the
// hierarchy.

struct Instance {
    vec4 rows[3]; // object to world, row-major 3x4
    // With surfaces: material, slot of its list of lights, number of lights in the lowest byte and
    // the tint above. Without: the bits of the tint. A tint is linear; the vertex colour has its
    // share. The last: place of its sprites, 0 without any.
    uvec4 tail;
};

// One, but no constant that a driver would put into the fragment shader: see `at_centroid`.
float one_of(Instance instance) {
    return float(min(instance.tail.z | 1u, 1u));
}

vec3 direction_to_world(Instance instance, vec3 direction) {
    return vec3(dot(instance.rows[0].xyz, direction), dot(instance.rows[1].xyz, direction),
                dot(instance.rows[2].xyz, direction));
}

// The place of a point of an object in the world, relative to the anchor of the view, which is near
// the eye: coordinates that are large, far from the origin of the world, cancel before anything is
// rounded to them.
vec3 from_anchor(Instance instance, vec3 position, vec3 anchor) {
    vec3 origin = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    return direction_to_world(instance, position) + (origin - anchor);
}

// Of scenes with surfaces only.
uint lights_of(Instance instance) {
    return instance.tail.z & 0xFFu;
}

vec3 tint_of_object(Instance instance) {
    return unpackUnorm4x8(instance.tail.z >> 8u).rgb;
}
