// The extrusion of a triangle: the same, to the bit, from every side of it, in whichever stage.
// The reference is `Extrusion` of the crate `shadows`. Includes need volume_constants.glsl and
// snap.glsl.

// A corner of a triangle with adjacency.
struct Corner {
    vec3 place;
    uint name;
};

// True if a triangle faces the light. It is looked at as the own triangle and as the neighbour of
// three others, and each must find the same, also where rounding decides: so the arithmetic begins
// at the corner of the least name, whichever comes first here.
bool faces_light(Corner a, Corner b, Corner c) {
    vec3 p = c.place;
    vec3 q = a.place;
    vec3 r = b.place;
    if (a.name < b.name && a.name < c.name) {
        p = a.place;
        q = b.place;
        r = c.place;
    } else if (b.name < c.name) {
        p = b.place;
        q = c.place;
        r = a.place;
    }
    precise vec3 along = q - p;
    precise vec3 beside = r - p;
    precise vec3 normal = vec3(along.y * beside.z - along.z * beside.y, along.z * beside.x - along.x * beside.z,
                               along.x * beside.y - along.y * beside.x);
    precise vec3 to_light = light.xyz - light.w * p;
    precise float facing = normal.x * to_light.x + normal.y * to_light.y + normal.z * to_light.z;
    return facing > 0.0;
}

// The place of a near cap's corner, a little farther than the surface that the cap is made of. The
// cap is to count as behind that, from either side, but the two may be rounded differently: drivers
// compute what comes from a geometry stage, or is clamped instead of clipped, by other arithmetic.
vec4 cap_clip(vec4 clip) {
    precise float z = clip.z * cap_depth.x - clip.w * cap_depth.y;
    return vec4(clip.xy, z, clip.w);
}

// False where the far end of volumes is a single point: infinitely far behind a sun.
bool has_far_end() {
    return light.w != 0.0 || far_w != 0.0;
}

// The place on the screen of the point at the far end behind a corner, seen from the light.
vec4 far_clip(vec3 place) {
    precise float factor = max(end.x * place.x + end.y * place.y + end.z * place.z + end.w, 0.0);
    precise vec3 away = max(light.w, far_w) * place - light.xyz * factor;
    precise float w = light.w != 0.0 ? 1.0 - factor : far_w;
    precise vec4 clip = view_proj() * vec4(away, w);
    return snapped(clip, steps);
}
