// Sprites: points and lines, drawn as squares and bars that face the camera. An object of sprites
// has vertices without a position of their own: each names a corner of a sprite. The sprites lie
// behind all instances, as vectors of four numbers:
//
//   head   radius in the object's space; vectors of an end; ends (of a point: 1, a line: 2)
//   end    position; square root of the linear colour in 24 bits, as a whole number
//          normal, where an end has two vectors
//
// A shader that includes this has `instances` at binding 0.

// Scenes without sprites are drawn by pipelines compiled without them: SIMD drivers execute both
// sides of a branch.
layout(constant_id = 13) const bool SPRITES = false;

// A little less than the room that boxes have around the ends for each metre of the radius.
const float SPRITE_REACH = 1.41422;

vec4 sprite_vector(uint place) {
    uint part = place & 3u;
    Instance block = instances[place >> 2u];
    return part == 3u ? uintBitsToFloat(block.tail) : block.rows[part];
}

// The index of the first vector of an end. Of a corner x is the end, 0 or 1, y the side, -1 or 1, z
// the sprite's number.
uint sprite_end(uint head_place, vec4 head, vec3 corner, float end) {
    uint ends = uint(head.z);
    uint number = uint(corner.z) * ends + min(uint(end), ends - 1u);
    return head_place + 1u + number * uint(head.y);
}

vec3 sprite_from_anchor(Instance instance, vec3 corner, mat4 view_proj, vec3 anchor) {
    uint head_place = instance.tail.w;
    vec4 head = sprite_vector(head_place);
    vec3 from = from_anchor(instance, sprite_vector(sprite_end(head_place, head, corner, 0.0)).xyz, anchor);
    vec3 to = from_anchor(instance, sprite_vector(sprite_end(head_place, head, corner, 1.0)).xyz, anchor);
    vec3 across = vec3(view_proj[0].x, view_proj[1].x, view_proj[2].x);
    vec3 down = vec3(view_proj[0].y, view_proj[1].y, view_proj[2].y);
    vec3 forward = normalize(cross(across, down));
    vec3 up = normalize(cross(across, forward));
    vec3 right = cross(forward, up);
    // Along the line as it is seen; to the right for points and for lines seen from their end.
    vec2 along = vec2(dot(to - from, right), dot(to - from, up));
    float seen = length(along);
    along = seen > 0.0 && seen < 1e18 ? along / seen : vec2(1.0, 0.0);
    vec2 offset = along * (corner.x * 2.0 - 1.0) + vec2(-along.y, along.x) * corner.y;
    // As large as the object's scale makes it, and never outside of its box.
    vec3 scale = vec3(length(instance.rows[0].xyz), length(instance.rows[1].xyz), length(instance.rows[2].xyz));
    float radius = head.x * max(scale.x, max(scale.y, scale.z));
    vec3 reach = head.x * SPRITE_REACH * scale;
    vec3 aside = clamp((right * offset.x + up * offset.y) * radius, -reach, reach);
    return (corner.x > 0.5 ? to : from) + aside;
}

// The place of a vertex relative to the anchor of the view: of an object of sprites a corner, else
// its own.
vec3 vertex_from_anchor(Instance instance, vec3 position, mat4 view_proj, vec3 anchor) {
    if (SPRITES && instance.tail.w != 0u) return sprite_from_anchor(instance, position, view_proj, anchor);
    return from_anchor(instance, position, anchor);
}

// The linear colour and the normal of a sprite's corner.
void sprite_look(Instance instance, vec3 corner, out vec3 colour, out vec3 normal) {
    vec4 head = sprite_vector(instance.tail.w);
    uint place = sprite_end(instance.tail.w, head, corner, corner.x);
    uint whole = uint(sprite_vector(place).w);
    vec3 root = vec3(whole & 0xFFu, whole >> 8u & 0xFFu, whole >> 16u & 0xFFu) / 255.0;
    colour = root * root;
    normal = head.y > 1.5 ? sprite_vector(place + 1u).xyz : vec3(0.0, 1.0, 0.0);
}
