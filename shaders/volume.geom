// Shadow volumes: extrudes triangles with adjacency away from a light.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "snap.glsl"
#include "volume_constants.glsl"
#include "volume.glsl"

layout(triangles_adjacency) in;
// Two caps of three, three sides of four.
layout(triangle_strip, max_vertices = 18) out;

layout(location = 0) in vec3 corner_place[];
layout(location = 1) in flat uint name[];

invariant gl_Position;

Corner corner(uint place) {
    return Corner(corner_place[place], name[place]);
}

void emit(vec4 clip) {
    gl_Position = clip;
    EmitVertex();
}

void emit_caps(uint b, uint c) {
    if (caps == NO_CAPS) return;
    emit(cap_clip(gl_in[0].gl_Position));
    emit(cap_clip(gl_in[b].gl_Position));
    emit(cap_clip(gl_in[c].gl_Position));
    EndPrimitive();
    if (caps == NEAR_CAPS || !has_far_end()) return;
    emit(far_clip(corner_place[0]));
    emit(far_clip(corner_place[c]));
    emit(far_clip(corner_place[b]));
    EndPrimitive();
}

void emit_side(uint from, uint to) {
    emit(gl_in[from].gl_Position);
    emit(far_clip(corner_place[from]));
    emit(gl_in[to].gl_Position);
    if (has_far_end()) emit(far_clip(corner_place[to]));
    EndPrimitive();
}

void main() {
    bool faces = faces_light(corner(0), corner(2), corner(4));
    if (is_robust == 0 && !faces) return;
    emit_caps(faces ? 2 : 4, faces ? 4 : 2);
    for (uint edge = 0; edge < 3; ++edge) {
        uint from = 2 * edge;
        uint to = (from + 2) % 6;
        // The neighbour runs along the edge in the other direction.
        bool is_open = name[from + 1] == name[from];
        if (is_open || faces_light(corner(to), corner(from), corner(from + 1)) != faces) {
            emit_side(faces ? from : to, faces ? to : from);
        }
    }
}
