// Shadow volumes: extrudes triangles with adjacency away from a light into a list of vertices,
// where there is no geometry stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "instance.glsl"
#include "snap.glsl"
#include "volume_constants.glsl"
#include "volume.glsl"

layout(local_size_x = 64) in;

struct Job {
    uint first_index;    // of the adjacency
    uint triangle_count;
    uint first_vertex;
    uint instance;
};

layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
// Five values per vertex, the first three its position.
layout(std430, binding = 1) readonly buffer Vertices { uint vertices[]; };
// Six indices per triangle.
layout(std430, binding = 2) readonly buffer Adjacency { uint adjacency[]; };
layout(std430, binding = 3) readonly buffer Jobs { Job jobs[]; };
layout(std430, binding = 4) writeonly buffer Extruded { vec4 extruded[]; };
// An indirect draw: its first value counts the vertices.
layout(std430, binding = 5) buffer Draw { uint draw[]; };

Corner corners[6];
vec4 clips[6];

void read_corners(Job job, uint first) {
    Instance instance = instances[job.instance];
    for (uint number = 0; number < 6; ++number) {
        uint index = adjacency[first + number];
        uint at = 5 * (job.first_vertex + index);
        vec3 position = uintBitsToFloat(uvec3(vertices[at], vertices[at + 1], vertices[at + 2]));
        precise vec3 place = from_anchor(instance, position, anchor.xyz);
        precise vec4 clip = view_proj() * vec4(place, 1.0);
        corners[number] = Corner(place, index);
        clips[number] = snapped(clip, steps);
    }
}

uint write_triangle(uint place, vec4 a, vec4 b, vec4 c) {
    extruded[place] = a;
    extruded[place + 1] = b;
    extruded[place + 2] = c;
    return place + 3;
}

void main() {
    Job job = jobs[gl_WorkGroupID.y];
    if (gl_GlobalInvocationID.x >= job.triangle_count) return;
    read_corners(job, job.first_index + 6 * gl_GlobalInvocationID.x);
    bool faces = faces_light(corners[0], corners[2], corners[4]);
    if (is_robust == 0 && !faces) return;

    bool has_far = has_far_end();
    bool extrudes[3];
    uint sides = 0;
    for (uint edge = 0; edge < 3; ++edge) {
        uint from = 2 * edge;
        uint to = (from + 2) % 6;
        bool is_open = corners[from + 1].name == corners[from].name;
        extrudes[edge] = is_open || faces_light(corners[to], corners[from], corners[from + 1]) != faces;
        sides += extrudes[edge] ? 1 : 0;
    }
    uint cap_count = caps == NO_CAPS ? 0 : caps == BOTH_CAPS && has_far ? 2 : 1;
    uint count = 3 * (cap_count + sides * (has_far ? 2 : 1));
    if (count == 0) return;
    uint place = atomicAdd(draw[0], count);

    uint b = faces ? 2 : 4;
    uint c = faces ? 4 : 2;
    if (cap_count > 0) {
        place = write_triangle(place, cap_clip(clips[0]), cap_clip(clips[b]), cap_clip(clips[c]));
    }
    if (cap_count > 1) {
        place = write_triangle(place, far_clip(corners[0].place), far_clip(corners[c].place), far_clip(corners[b].place));
    }
    for (uint edge = 0; edge < 3; ++edge) {
        if (!extrudes[edge]) continue;
        uint next = (2 * edge + 2) % 6;
        uint from = faces ? 2 * edge : next;
        uint to = faces ? next : 2 * edge;
        vec4 far_from = far_clip(corners[from].place);
        place = write_triangle(place, clips[from], far_from, clips[to]);
        if (has_far) place = write_triangle(place, clips[to], far_from, far_clip(corners[to].place));
    }
}
