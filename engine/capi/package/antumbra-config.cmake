# Targets for find_package(antumbra): antumbra::antumbra, and antumbra::static, which needs no file
# when the program runs. A package manager may leave the static library out.
get_filename_component(_antumbra_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET antumbra::antumbra)
    add_library(antumbra::antumbra SHARED IMPORTED)
    set_target_properties(antumbra::antumbra PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_antumbra_prefix}/include")
    if(WIN32)
        set(_antumbra_import "${_antumbra_prefix}/lib/libantumbra.dll.a")
        if(MSVC)
            set(_antumbra_import "${_antumbra_prefix}/lib/antumbra.lib")
            if(NOT EXISTS "${_antumbra_import}")
                message(FATAL_ERROR "antumbra: make the import library of MSVC once: "
                    "lib /machine:x64 /def:${_antumbra_prefix}/lib/antumbra.def /out:${_antumbra_import}")
            endif()
        endif()
        set_target_properties(antumbra::antumbra PROPERTIES
            IMPORTED_LOCATION "${_antumbra_prefix}/bin/antumbra.dll"
            IMPORTED_IMPLIB "${_antumbra_import}")
        set(_antumbra_system stdc++ kernel32 ntdll userenv ws2_32 dbghelp)
        unset(_antumbra_import)
    else()
        set_target_properties(antumbra::antumbra PROPERTIES
            IMPORTED_LOCATION "${_antumbra_prefix}/lib/libantumbra.so.1"
            IMPORTED_SONAME "libantumbra.so.1")
        set(_antumbra_system gcc_s pthread dl m stdc++)
    endif()
    if(EXISTS "${_antumbra_prefix}/lib/libantumbra.a" AND NOT MSVC)
        add_library(antumbra::static STATIC IMPORTED)
        set_target_properties(antumbra::static PROPERTIES
            IMPORTED_LOCATION "${_antumbra_prefix}/lib/libantumbra.a"
            INTERFACE_LINK_LIBRARIES "${_antumbra_system}"
            INTERFACE_INCLUDE_DIRECTORIES "${_antumbra_prefix}/include")
    endif()
    unset(_antumbra_system)
endif()
# The folder of snap.glsl, which the vertex shaders of a host include.
set(ANTUMBRA_SHADER_DIR "${_antumbra_prefix}/share/antumbra")
unset(_antumbra_prefix)
