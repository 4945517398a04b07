// The skinning pass: morphs the vertices of a mesh, then skins them, and writes them where all
// passes read them. Colours and coordinates do not change and are not touched.
#version 460

layout(local_size_x = 64) in;

// Five values per vertex: position, normal as snorm8, colour.
layout(std430, binding = 0) writeonly buffer Vertices { uint vertices[]; };
// Ten values per vertex: normal and tangent as snorm16, then the other attributes of shading.
layout(std430, binding = 1) writeonly buffer Surfaces { uint surfaces[]; };
// The constant part: vertices at rest, their joints and weights, the targets' differences.
layout(std430, binding = 2) readonly buffer MeshData { uint mesh_data[]; };
// The pose: the joints, and the targets with weights.
layout(std430, binding = 3) readonly buffer Poses { uint poses[]; };
// Results of visibility tests: a mesh that stays hidden is not worked on.
layout(std430, binding = 4) readonly buffer Results { uint results[]; };
// A flag per mesh of this frame: its vertices were written.
layout(std430, binding = 5) writeonly buffer Written { uint written[]; };

// All but the counts are numbers of values.
layout(push_constant) uniform Constants {
    uint vertex_count;
    uint first_vertex;
    uint rest;
    uint skin;
    uint joint_sets; // groups of four joints a vertex; 0 without a skin
    uint joints;
    uint targets;
    uint target_count;
    uint result; // of the test that decides, or NOTHING
    uint threshold_samples; // which the result must exceed
    uint flag; // the mesh's flag, or NOTHING
};

const uint REST_VALUES = 7;
const uint SET_VALUES = 6;
const uint JOINT_VALUES = 12;
const uint TARGET_VALUES = 4;
const uint NOTHING = 0xffffffff;

vec3 rest_vector(uint at) {
    return uintBitsToFloat(uvec3(mesh_data[at], mesh_data[at + 1], mesh_data[at + 2]));
}

vec4 pose_row(uint at) {
    return uintBitsToFloat(uvec4(poses[at], poses[at + 1], poses[at + 2], poses[at + 3]));
}

// The difference that a target adds; `list` is where its list begins, if it has one.
vec3 added(uint list, uint vertex) {
    return list == NOTHING ? vec3(0.0) : rest_vector(list + 3 * vertex);
}

float largest_of(vec3 v) {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// By a power of two, so that nothing is rounded: squares of tiny numbers would be zero.
vec3 near_one(vec3 v, float largest) {
    int exponent;
    frexp(largest, exponent);
    return ldexp(v, ivec3(-clamp(exponent, -126, 126)));
}

vec3 unit(vec3 direction, vec3 otherwise) {
    direction = near_one(direction, largest_of(direction));
    float squared = dot(direction, direction);
    return squared > 0.0 && !isinf(squared) ? direction * inversesqrt(squared) : otherwise;
}

void main() {
    if (result != NOTHING && results[result] <= threshold_samples) return;
    if (flag != NOTHING && gl_GlobalInvocationID.x == 0) written[flag] = 1;
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint vertex = gl_GlobalInvocationID.x; vertex < vertex_count; vertex += stride) {
        uint at = rest + REST_VALUES * vertex;
        vec3 position = rest_vector(at);
        vec2 normal_z_sides = unpackSnorm2x16(mesh_data[at + 4]);
        vec3 rest_normal = vec3(unpackSnorm2x16(mesh_data[at + 3]), normal_z_sides.x);
        vec2 tangent_z_sign = unpackSnorm2x16(mesh_data[at + 6]);
        vec3 rest_tangent = vec3(unpackSnorm2x16(mesh_data[at + 5]), tangent_z_sign.x);
        vec3 normal = rest_normal;
        vec3 tangent = rest_tangent;
        float bitangent_turn = 1.0;
        for (uint number = 0; number < target_count; ++number) {
            uint target = targets + TARGET_VALUES * number;
            float weight = uintBitsToFloat(poses[target]);
            position += weight * added(poses[target + 1], vertex);
            normal += weight * added(poses[target + 2], vertex);
            tangent += weight * added(poses[target + 3], vertex);
        }
        if (joint_sets > 0) {
            vec4 rows[3] = vec4[](vec4(0.0), vec4(0.0), vec4(0.0));
            for (uint set = 0; set < joint_sets; ++set) {
                uint hangs = skin + SET_VALUES * (joint_sets * vertex + set);
                for (uint which = 0; which < 4; ++which) {
                    uint joint = mesh_data[hangs + which / 2] >> 16 * (which % 2) & 0xffff;
                    float weight = uintBitsToFloat(mesh_data[hangs + 2 + which]);
                    if (weight != 0.0) {
                        for (uint row = 0; row < 3; ++row) {
                            rows[row] += weight * pose_row(joints + JOINT_VALUES * joint + 4 * row);
                        }
                    }
                }
            }
            vec4 point = vec4(position, 1.0);
            position = vec3(dot(rows[0], point), dot(rows[1], point), dot(rows[2], point));
            // Normals go by the inverse of the transpose, which is the cofactors but for a factor.
            float largest = max(largest_of(rows[0].xyz), max(largest_of(rows[1].xyz), largest_of(rows[2].xyz)));
            for (uint row = 0; row < 3; ++row) rows[row].xyz = near_one(rows[row].xyz, largest);
            vec3 cofactors[3] = vec3[](cross(rows[1].xyz, rows[2].xyz), cross(rows[2].xyz, rows[0].xyz),
                                       cross(rows[0].xyz, rows[1].xyz));
            float turned = dot(rows[0].xyz, cofactors[0]) < 0.0 ? -1.0 : 1.0;
            // With both sides of each triangle, a mirror shows the other one: as in surface.vert.
            bool has_both_sides = normal_z_sides.y > 0.5;
            tangent *= has_both_sides ? turned : 1.0;
            turned = has_both_sides ? 1.0 : turned;
            bitangent_turn = turned;
            normal = turned * vec3(dot(cofactors[0], normal), dot(cofactors[1], normal),
                                   dot(cofactors[2], normal));
            tangent = vec3(dot(rows[0].xyz, tangent), dot(rows[1].xyz, tangent),
                           dot(rows[2].xyz, tangent));
        }
        normal = unit(normal, rest_normal);
        tangent = unit(tangent, rest_tangent);
        uint place = 5 * (first_vertex + vertex);
        uvec3 values = floatBitsToUint(position);
        vertices[place] = values.x;
        vertices[place + 1] = values.y;
        vertices[place + 2] = values.z;
        vertices[place + 3] = packSnorm4x8(vec4(normal, 0.0));
        place = 10 * (first_vertex + vertex);
        surfaces[place] = packSnorm2x16(normal.xy);
        surfaces[place + 1] = packSnorm2x16(vec2(normal.z, normal_z_sides.y));
        surfaces[place + 2] = packSnorm2x16(tangent.xy);
        surfaces[place + 3] = packSnorm2x16(vec2(tangent.z, bitangent_turn * tangent_z_sign.y));
    }
}
