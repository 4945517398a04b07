// The line of a segment of an edge in a view. Includes need edge_constants.glsl, edge_strip.glsl
// and instance.glsl.

// Mirrors `EdgeSegment` of the renderer.
struct Segment {
    uint from; // vertices
    uint to;
    uint left;  // the third corner of a face at it
    uint right; // the same of another face, or NO_FACE
    uint run;   // the first segment of its pattern of dashes, or SMOOTH
};

const uint NO_FACE = 0xFFFFFFFFu;
// An edge that is drawn where it is a silhouette, and then has no pattern of its own.
const uint SMOOTH = 0xFFFFFFFFu;

// Words of a vertex; the first three are its position.
const uint VERTEX_WORDS = 5;

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 1) readonly buffer Segments { Segment segments[]; };
layout(std430, binding = 2) readonly buffer Vertices { float words[]; };

// A point must have a place on the screen, and none so far away that its pixels cannot be counted.
const float GUARD = 4.0;

// The steepest slope, in pixels of depth per pixel, that lines are brought forward over faces
// beside their own by.
const float STEEP = 2.0;

vec3 place_of(Instance instance, uint vertex) {
    uint word = vertex * VERTEX_WORDS;
    return from_anchor(instance, vec3(words[word], words[word + 1], words[word + 2]), anchor.xyz);
}

vec4 clip_of(vec3 place) {
    precise vec4 clip = view_proj() * vec4(place, 1.0);
    return clip;
}

vec3 on_screen(vec4 clip) {
    precise vec3 place = vec3(clip.xy / clip.w * half_size, clip.z / clip.w);
    return place;
}

// Cuts a segment off at a plane with these distances of its ends.
void cut(float from, float to, inout vec2 part) {
    if (from < 0.0 && to < 0.0) part = vec2(1.0, 0.0);
    else if (from < 0.0) part.x = max(part.x, from / (from - to));
    else if (to < 0.0) part.y = min(part.y, from / (from - to));
}

// Returns a segment on the screen, without a place in a pattern.
Line cut_line(vec4 from, vec4 to) {
    vec2 part = vec2(0.0, 1.0);
    cut(from.w - from.z, to.w - to.z, part);
    cut(from.z, to.z, part);
    vec2 reach = vec2(GUARD);
    for (int axis = 0; axis < 2; ++axis) {
        cut(reach[axis] * from.w - from[axis], reach[axis] * to.w - to[axis], part);
        cut(reach[axis] * from.w + from[axis], reach[axis] * to.w + to[axis], part);
    }
    if (!(part.x < part.y)) return Line(vec3(0.0), vec3(0.0), vec2(0.0), vec2(0.0));
    precise vec4 start = part.x > 0.0 ? from + (to - from) * part.x : from;
    precise vec4 end = part.y < 1.0 ? from + (to - from) * part.y : to;
    return Line(on_screen(start), on_screen(end), vec2(0.0), vec2(0.0));
}

// The signed distance of a point from the plane of an edge and the eye, up to a factor.
float beside(vec3 from, vec3 to, vec3 place) {
    precise vec3 sight = eye.xyz - from * eye.w;
    precise float side = dot(cross(to - from, sight), place - from);
    return side;
}

float step_at(float depth) {
    return depth * depth_step.x + depth_step.y;
}

// How a face lies beside its edge: the depth by which its corner is nearer, the distance to that in
// pixels, and 0 for a corner without a place on the screen.
struct Slope {
    float rise;
    float distance_px;
    float is_known;
};

Slope slope_of_face(Line line, vec4 corner) {
    if (!(corner.w > corner.z && corner.w > 0.0)) return Slope(0.0, 1.0, 0.0);
    vec3 place = on_screen(corner);
    vec2 along = line.to.xy - line.from.xy;
    vec2 away = place.xy - line.from.xy;
    float length_2 = max(dot(along, along), 1.0e-12);
    float foot = clamp(dot(away, along) / length_2, 0.0, 1.0);
    float rise = place.z - mix(line.from.z, line.to.z, foot);
    float distance_px = abs(away.x * along.y - away.y * along.x) * inversesqrt(length_2);
    return Slope(rise, max(distance_px, 1.0e-6), 1.0);
}

// Returns how much nearer the ends of a line must be to lie before a face of its edge, over half of
// its width: as much as the face rises there, but no nearer than the face itself comes. Over other
// faces in the same plane, STEEP pixels.
vec2 rise_of_face(Line line, Slope face) {
    float reach = half_width + 1.0;
    vec2 most = STEEP * reach * vec2(step_at(line.from.z), step_at(line.to.z));
    if (face.is_known == 0.0) return most;
    float rise = reach * abs(face.rise) / face.distance_px;
    return max(min(vec2(rise), most), vec2(clamp(face.rise, 0.0, rise)));
}

// Returns the same before a round surface of which the edge is a silhouette: over half of the width
// it rises by more than the face at the edge, which is seen nearly edge-on. Its radius follows from
// the height of that face and its fold.
vec2 rise_of_round(Line line, float face_rise, float fold_sine) {
    vec2 steps = max(vec2(step_at(line.from.z), step_at(line.to.z)), vec2(1.0e-30));
    vec2 radius_px = max(face_rise, 0.0) / max(fold_sine, 1.0e-3) / steps;
    return min(sqrt(2.0 * (half_width + 1.0) * radius_px), radius_px) * steps;
}

// Returns the sine of the fold between two faces at an edge.
float fold_sine(vec3 from, vec3 to, vec3 left, vec3 right) {
    vec3 along = normalize(to - from);
    vec3 into_left = left - from - along * dot(left - from, along);
    vec3 into_right = right - from - along * dot(right - from, along);
    return length(cross(into_left, into_right)) / max(length(into_left) * length(into_right), 1.0e-30);
}

// Returns the lengths of the segments of a pattern before one, in pixels.
float run_before(Instance instance, uint run, uint segment) {
    float sum = 0.0;
    for (uint number = run; number < segment; ++number) {
        vec4 from = clip_of(place_of(instance, segments[number].from));
        Line line = cut_line(from, clip_of(place_of(instance, segments[number].to)));
        precise vec2 reach = line.to.xy - line.from.xy;
        precise float length_px = sqrt(reach.x * reach.x + reach.y * reach.y);
        sum += length_px;
    }
    return sum;
}

// Returns the line of a segment; none where it is smooth and no silhouette, or not in view.
Line line_of(Instance instance, uint number) {
    Line none = Line(vec3(0.0), vec3(0.0), vec2(0.0), vec2(0.0));
    Segment segment = segments[number];
    vec3 from = place_of(instance, segment.from);
    vec3 to = place_of(instance, segment.to);
    vec3 left = place_of(instance, segment.left);
    vec3 right = segment.right == NO_FACE ? left : place_of(instance, segment.right);
    // A silhouette: the eye sees both faces on one side.
    float sides = sign(beside(from, to, left)) * sign(beside(from, to, right));
    if (segment.run == SMOOTH && sides < 0.0) return none;
    Line line = cut_line(clip_of(from), clip_of(to));
    precise vec2 reach = line.to.xy - line.from.xy;
    precise float length_px = sqrt(reach.x * reach.x + reach.y * reach.y);
    if (!(length_px > 1.0e-3)) return none;
    if (dash > 0.0) {
        if (segment.run == SMOOTH) {
            // What is a silhouette changes with the view: its pattern lies on the screen.
            line.along = abs(reach.x) >= abs(reach.y) ? vec2(line.from.x, line.to.x) : vec2(line.from.y, line.to.y);
        } else {
            float before = run_before(instance, segment.run, number);
            line.along = vec2(before, before + length_px);
        }
    }
    Slope left_slope = slope_of_face(line, clip_of(left));
    Slope right_slope = slope_of_face(line, clip_of(right));
    vec2 rise = max(rise_of_face(line, left_slope), rise_of_face(line, right_slope));
    if (segment.run == SMOOTH) {
        float face_rise = max(left_slope.rise, right_slope.rise);
        rise = max(rise, rise_of_round(line, face_rise, fold_sine(from, to, left, right)));
    }
    rise += 0.5 * vec2(step_at(line.from.z), step_at(line.to.z));
    vec2 depths = vec2(line.from.z, line.to.z);
    line.from.z = min(line.from.z + rise.x, 1.0);
    line.to.z = min(line.to.z + rise.y, 1.0);
    line.rise = vec2(line.from.z, line.to.z) - depths;
    return line;
}
