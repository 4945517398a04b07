#!/usr/bin/env bash
# Builds the C interface and installs it: `engine/capi/install.sh PREFIX [CARGO OPTION..]`.
#
# Below PREFIX lie then include/antumbra.h and include/antumbra_vulkan.h, the shared and the static library, a pkg-config
# file, a CMake package, and share/antumbra/snap.glsl for shaders of hosts. What follows PREFIX goes to `cargo build`,
# `--release` if there is nothing: `install.sh /usr/local`, `install.sh out --profile dev`. At the end it prints what to
# do where the library is not found. On Linux; with `--target x86_64-pc-windows-gnu` for Windows, too, where
# bin/antumbra.dll has an import library for mingw-w64, and lib/antumbra.def lists its functions for other linkers.
set -euo pipefail

{ [ "$#" -ge 1 ] && [[ $1 != -* ]]; } || { echo "usage: install.sh PREFIX [CARGO OPTION..]" >&2; exit 2; }
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
shift
[ "$#" -gt 0 ] || set -- --release
cd "$(dirname "${BASH_SOURCE[0]}")"

# Cargo says where the files are: profiles and target folders are the caller's choice.
built=$(cargo build -p antumbra-capi --message-format json-render-diagnostics "$@" |
    grep -o '"[^"]*antumbra_capi\.\(so\|a\|dll\)"' | tr -d '"' | sort -u)
library=$(grep -E '/(lib)?antumbra_capi\.(so|dll)$' <<<"$built")
archive=$(grep '/libantumbra_capi\.a$' <<<"$built")
version=$(cargo pkgid -p antumbra-capi | sed 's/.*[#@]//')

install -d "$prefix"/share/antumbra "$prefix"/include "$prefix"/lib/pkgconfig "$prefix"/lib/cmake/antumbra
install -m 644 include/antumbra.h include/antumbra_vulkan.h "$prefix/include/"
install -m 644 ../../shaders/snap.glsl "$prefix/share/antumbra/"
install -m 644 "$archive" "$prefix/lib/libantumbra.a"
if [[ $library == *.dll ]]; then
    # What the archive needs of the system: `cargo rustc -- --print native-static-libs` says it.
    private="-lstdc++ -lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp"
    install -D -m 755 "$library" "$prefix/bin/antumbra.dll"
    # Cargo's import library names the file that Cargo wrote.
    {
        echo "LIBRARY antumbra.dll"
        echo "EXPORTS"
        x86_64-w64-mingw32-objdump -p "$library" | grep -oE '\bantumbra_[a-z0-9_]+$' | sort -u
    } >"$prefix/lib/antumbra.def"
    x86_64-w64-mingw32-dlltool -d "$prefix/lib/antumbra.def" -l "$prefix/lib/libantumbra.dll.a"
else
    private="-lgcc_s -lpthread -ldl -lm -lstdc++"
    # The name that programs look for, as build.rs gives it.
    soname=$(LC_ALL=C objdump -p "$library" | sed -n 's/^ *SONAME *//p')
    install -m 755 "$library" "$prefix/lib/$soname"
    ln -sf "$soname" "$prefix/lib/libantumbra.so"
fi
sed "s/@VERSION@/$version/; s/@PRIVATE@/$private/" package/antumbra.pc.in >"$prefix/lib/pkgconfig/antumbra.pc"
cmake=$prefix/lib/cmake/antumbra
sed "s/@SONAME@/${soname:-}/" package/antumbra-config.cmake.in >"$cmake/antumbra-config.cmake"
sed "s/@VERSION@/$version/" package/antumbra-config-version.cmake.in >"$cmake/antumbra-config-version.cmake"
echo "installed to $prefix"
if [[ $library == *.dll ]]; then
    echo "Put bin/antumbra.dll beside a program, or its folder into PATH."
    exit
fi
cat <<END
If the library is not found:
- when a program starts: run ldconfig once as root, for a prefix of the system such as /usr/local. For another prefix,
  set LD_LIBRARY_PATH=$prefix/lib or link with -Wl,-rpath,$prefix/lib
- when a program is built: set PKG_CONFIG_PATH=$prefix/lib/pkgconfig
  or call CMake with -DCMAKE_PREFIX_PATH=$prefix
END
