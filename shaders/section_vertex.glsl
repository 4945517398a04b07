// Section planes, for vertex shaders: what they do to each object. A shader that includes this
// defines SECTION_BINDING, the first of two bindings of storage buffers, as `section.glsl` does.

// Sixteen bits per instance; `section.glsl` says what they mean.
layout(std430, binding = SECTION_BINDING + 1) readonly buffer SectionStates { uint section_states[]; };

layout(location = 14) flat out uint section_state;

uint state_of(uint instance) {
    return section_states[instance >> 1u] >> ((instance & 1u) * 16u) & 0xFFFFu;
}
