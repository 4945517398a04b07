// Sets the levels of a Bezier patch: those of its edges, which the CPU decides, and inside of it
// the highest of them.
#version 460

layout(vertices = 16) out;

// Per patch and side: twice the level, and 1 more if the side runs against the canonical direction
// of its edge; see `scene::PatchSides`.
layout(std430, binding = 2) readonly buffer Sides { uvec4 sides[]; };

layout(location = 0) in vec3 place[];
layout(location = 0) out vec3 passed_place[];
layout(location = 1) patch out uvec4 passed_sides;

void main() {
    passed_place[gl_InvocationID] = place[gl_InvocationID];
    if (gl_InvocationID == 0) {
        // The sides v = 0, u = 1, v = 1, u = 0; of the outer levels u = 0 is the first.
        uvec4 of_patch = sides[gl_PrimitiveID];
        vec4 levels = vec4(of_patch >> 1);
        gl_TessLevelOuter[0] = levels.w;
        gl_TessLevelOuter[1] = levels.x;
        gl_TessLevelOuter[2] = levels.y;
        gl_TessLevelOuter[3] = levels.z;
        float highest = max(max(levels.x, levels.y), max(levels.z, levels.w));
        gl_TessLevelInner[0] = highest;
        gl_TessLevelInner[1] = highest;
        passed_sides = of_patch;
    }
}
