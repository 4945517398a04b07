# Targets for find_package(antumbra): antumbra::antumbra, and antumbra::static, which needs no file
# when the program runs.
get_filename_component(_antumbra_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET antumbra::antumbra)
    add_library(antumbra::antumbra SHARED IMPORTED)
    set_target_properties(antumbra::antumbra PROPERTIES
        IMPORTED_LOCATION "${_antumbra_prefix}/lib/libantumbra.so.1"
        IMPORTED_SONAME "libantumbra.so.1"
        INTERFACE_INCLUDE_DIRECTORIES "${_antumbra_prefix}/include")
    add_library(antumbra::static STATIC IMPORTED)
    set_target_properties(antumbra::static PROPERTIES
        IMPORTED_LOCATION "${_antumbra_prefix}/lib/libantumbra.a"
        INTERFACE_LINK_LIBRARIES "gcc_s;pthread;dl;m;stdc++"
        INTERFACE_INCLUDE_DIRECTORIES "${_antumbra_prefix}/include")
endif()
# The folder of snap.glsl, which the vertex shaders of a host include.
set(ANTUMBRA_SHADER_DIR "${_antumbra_prefix}/share/antumbra")
unset(_antumbra_prefix)
