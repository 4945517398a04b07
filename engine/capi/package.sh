#!/usr/bin/env bash
# Makes what programs in C take: `engine/capi/package.sh FOLDER [CARGO OPTION..]`.
#
# FOLDER has then antumbra-VERSION-TARGET.zip with what `install.sh` installs, the programs in C and C++, and the
# licences; SHA512SUMS of all archives there; and recipes that take these archives: `vcpkg` (an overlay port) and `conan`.
# Options go to `cargo build`, `--release` if there are none. `--target x86_64-pc-windows-gnu` adds the archive for
# Windows to the same folder. Debug information is stripped. Needs CMake, which writes the archives.
set -euo pipefail

{ [ "$#" -ge 1 ] && [[ $1 != -* ]]; } || { echo "usage: package.sh FOLDER [CARGO OPTION..]" >&2; exit 2; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
shift
[ "$#" -gt 0 ] || set -- --release
capi=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

target=$(rustc -vV | sed -n 's/^host: //p')
options=("$@")
for ((i = 0; i < ${#options[@]}; i++)); do
    case ${options[i]} in
        --target) target=${options[i + 1]:?"package.sh: --target has no value"} ;;
        --target=*) target=${options[i]#--target=} ;;
    esac
done
strip=strip
[ "$target" != x86_64-pc-windows-gnu ] || strip=x86_64-w64-mingw32-strip

scratch=$(mktemp -d "$folder/.package.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
"$capi/install.sh" "$scratch/prefix" "$@" >"$scratch/installed"
version=$(sed -n 's/^Version: //p' "$scratch/prefix/lib/pkgconfig/antumbra.pc")
name=antumbra-$version-$target
mv "$scratch/prefix" "$scratch/$name"
for file in "$scratch/$name"/bin/*.dll "$scratch/$name"/lib/libantumbra.so.* "$scratch/$name"/lib/libantumbra.a; do
    [ ! -e "$file" ] || "$strip" --strip-debug "$file"
done
# In place of a link, which some programs unpack as a file with the link's text: linkers read this.
link=$scratch/$name/lib/libantumbra.so
[ ! -e "$link" ] || {
    soname=$(readlink "$link")
    rm "$link"
    echo "INPUT($soname)" >"$link"
}
cp -r "$capi/examples" "$capi/LICENSE-APACHE" "$capi/LICENSE-MIT" "$scratch/$name/"
sed "s/@VERSION@/$version/" "$capi/package/README.md.in" >"$scratch/$name/README.md"
(cd "$scratch" && cmake -E tar cf "$folder/$name.zip" --format=zip "$name")
(cd "$folder" && sha512sum -- antumbra-*.zip >SHA512SUMS)

mkdir -p "$folder/vcpkg/antumbra" "$folder/conan"
for recipe in vcpkg/antumbra/vcpkg.json vcpkg/antumbra/portfile.cmake conan/conanfile.py; do
    sed "s/@VERSION@/$version/" "$capi/package/${recipe/antumbra\//}.in" >"$folder/$recipe"
done
cp -r "$capi/package/conan/test_package" "$folder/conan/"
cp "$capi/examples/cpp/decisions.cpp" "$folder/conan/test_package/"
echo "$folder/$name.zip"
