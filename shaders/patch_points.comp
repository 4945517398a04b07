// Computes the points of a surface of Bezier patches that are asked for.
#version 460
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;

// Per point: its patch, its side, u and v; see `scene::SurfacePoint`.
layout(std430, binding = 0) readonly buffer Points { uvec4 points[]; };
// Sixteen indices of control points per patch.
layout(std430, binding = 1) readonly buffer Patches { uint patches[]; };
// Three coordinates per control point.
layout(std430, binding = 2) readonly buffer ControlPoints { float control_points[]; };
// Per point: its position, and its normal as snorm8; see `scene::EvaluatedPoint`.
layout(std430, binding = 3) writeonly buffer Evaluated { uvec4 evaluated[]; };

layout(push_constant) uniform Constants { uint point_count; };

vec3 control_point(uint patch_index, uint place) {
    uint point = patches[patch_index * 16 + place] * 3;
    return vec3(control_points[point], control_points[point + 1], control_points[point + 2]);
}

#include "patch_point.glsl"

void main() {
    // As many threads as there are groups for.
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint index = gl_GlobalInvocationID.x; index < point_count; index += stride) {
        uvec4 point = points[index];
        evaluated[index] =
            evaluated_point(point.x, point.y, uintBitsToFloat(point.z), uintBitsToFloat(point.w));
    }
}
