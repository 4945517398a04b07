// The pictures that spots project, as slides do: a square across the light's direction, whose sides
// the edge of the cone touches.

// The steps to the next pixels, in the world: derivatives are defined before anything is discarded.
vec3 picture_step_x;
vec3 picture_step_y;

// The place in the picture, from its upper left, of what lies in this direction.
vec2 picture_place(PunctualLight light, vec3 from_light) {
    vec3 down = cross(light.direction.xyz, light.right);
    // What is behind the light is dark already.
    float along = max(dot(light.direction.xyz, from_light), 1e-6);
    return 0.5 + 0.5 * vec2(dot(light.right, from_light), dot(down, from_light)) / along;
}

// The colour that the picture of a light gives to its light; white without one.
vec3 picture_colour(PunctualLight light, vec3 from_light) {
    if (!has_texture(light.picture)) return vec3(1.0);
    vec2 place = picture_place(light, from_light);
    vec2 step_x = picture_place(light, from_light + picture_step_x) - place;
    vec2 step_y = picture_place(light, from_light + picture_step_y) - place;
    vec3 found = vec3(1.0);
#ifdef INDEXED_TEXTURES
    uint number = texture_number(light.picture);
    found = textureGrad(textures[nonuniformEXT(number)], vec3(place, 0.0), step_x, step_y).rgb;
#else
    vec3 at = vec3(place, float((light.picture >> 5) & 2047u));
    uint page = light.picture & 15u;
#define PICTURE_OF_PAGE(number) \
    if ((PICTURE_PAGES & (1u << number)) != 0u && page == number) \
        found = textureGrad(pages[number], at, step_x, step_y).rgb
    PICTURE_OF_PAGE(0);
    PICTURE_OF_PAGE(1);
    PICTURE_OF_PAGE(2);
    PICTURE_OF_PAGE(3);
    PICTURE_OF_PAGE(4);
    PICTURE_OF_PAGE(5);
    PICTURE_OF_PAGE(6);
    PICTURE_OF_PAGE(7);
    PICTURE_OF_PAGE(8);
    PICTURE_OF_PAGE(9);
    PICTURE_OF_PAGE(10);
    PICTURE_OF_PAGE(11);
#undef PICTURE_OF_PAGE
#endif
    return found;
}
