// The cap pass: the depth of a section plane, and whether it shows there.
#include "cap_constants.glsl"
#include "section.glsl"

// The depth of the plane of a cap under the fragment; 0, which is no depth of anything, where it
// shows none: outside of the object's box, before the near plane or behind the far one, and where
// other planes remove it. In a union those show it that remove what is there.
float cap_depth(Cap cap) {
    uint number = cap.tail.x;
    vec4 plane = sections[0].planes[number];
    vec3 place = section_place(0.0);
    precise float depth = -((plane.x * place.x + plane.y * place.y) + plane.w) / plane.z;
    place.z = depth;
    float w = dot(cap.w, vec4(place, 1.0));
    vec3 in_box = vec3(dot(cap.box[0], vec4(place, 1.0)), dot(cap.box[1], vec4(place, 1.0)),
                       dot(cap.box[2], vec4(place, 1.0)));
    bool shows = depth > 0.0 && depth <= 1.0 && w > 0.0 && all(lessThanEqual(abs(in_box), vec3(w)));
    bool wanted = sections[0].mode != SECTION_UNION;
    for (uint other = 0u; other < sections[0].count; ++other) {
        if (other != number) shows = shows && plane_keeps_of(cap.tail.y, other, place) == wanted;
    }
    return shows ? depth : 0.0;
}
