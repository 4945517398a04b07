// The proxy pass with flags: a fragment that passes the depth test says that its box shows.
#version 460
#extension GL_KHR_memory_scope_semantics : require

layout(early_fragment_tests) in;

layout(location = 0) flat in uint test;

layout(std430, binding = 1) buffer Flags { uint flags[]; };

void main() {
    // Many fragments write the same.
    atomicStore(flags[test], 1u, gl_ScopeDevice, gl_StorageSemanticsNone, gl_SemanticsRelaxed);
}
