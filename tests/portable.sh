#!/bin/bash
# portable.sh - the code on another processor: cross-built for aarch64 and tested under qemu-user (`make portable`).
#
# Built are the layers below the light: core, maps, visibility without pictures, sim. Tested are the unit tests of these, with a stand-in
# for Criterion (portable/criterion/criterion.h), which cannot run under qemu-user. Left out are tests that start the program, draw, or
# need libraries for it: no_memory, kills, layers (of the sources), sums, hidden*, curved_scene, ray_tree, and those of the window.
# The libraries come from Debian's arm64 packages, unpacked below build/, not installed: some exclude their amd64 twins.
set -e
arm=build/arm64
root=$arm/root
cc=aarch64-linux-gnu-gcc
packages="libgeos-dev libgeos-c1v5 libgeos3.11.1 libminizip-dev libminizip1 libexpat1-dev libexpat1 libjansson-dev libjansson4
    zlib1g-dev zlib1g libzip-dev libzip4 libbz2-1.0 libssl3 libpng-dev libpng16-16 libwebp-dev libwebp7 libassimp-dev libassimp5
    libdraco7 libstdc++6 libgcc-s1 libgomp1"

if [ ! -e $root/unpacked ]; then
    echo "portable: libraries for arm64"
    sudo=$([ "$(id -u)" = 0 ] || echo sudo)
    dpkg --print-foreign-architectures | grep -q arm64 || { $sudo dpkg --add-architecture arm64 && $sudo apt-get -q update; }
    rm -rf $root && mkdir -p $root/packages
    # shellcheck disable=SC2046
    (cd $root/packages && apt-get -q download $(printf '%s:arm64 ' $packages) >/dev/null 2>&1) || { echo 'portable: no packages for arm64'; exit 1; }
    for package in $root/packages/*.deb; do dpkg -x "$package" $root; done
    touch $root/unpacked
fi
libraries=$root/usr/lib/aarch64-linux-gnu
# Headers of no machine in particular are the installed ones.
mkdir -p $root/common && ln -sfn /usr/include/cglm $root/common/cglm && ln -sf /usr/include/xxhash.h $root/common/xxhash.h

layers='engine/core maps/building maps/curved maps/enclose maps/plan maps/polygons maps/sweethome maps/doom maps visibility
    visibility/cells visibility/soup visibility/trees visibility/query visibility/pairs visibility/prepare visibility/bezier
    visibility/rays engine/sim'
left_out='test_no_memory test_kills test_layers test_sums test_sums_cells sums_fixture test_ray_tree test_leaves test_wad test_wad_doors
    test_wad_faults wad_fixture test_memory fail_malloc hostile_cost make_hostile'
sources=$(for layer in $layers; do ls "$layer"/*.c; done)
for test in $(find tests/core tests/maps tests/visibility tests/sim -name '*.c' ! -path 'tests/visibility/hidden/*' | sort); do
    [[ " $(echo $left_out) " == *" $(basename "$test" .c) "* ]] || sources+=" $test"
done
for part in curved_fixture draft_fixture fixture gltf_fixture home_fixture hostile patch_oracle prt_scene soup_fixture soups support \
    quake_builder wad_builder; do
    sources+=" $(find tests/support -name "$part.c")"
done
sources+=" tests/portable/runner.c engine/bench/ray_patches.c"

echo "portable: $(echo $sources | wc -w) files for aarch64"
flags="-std=c17 -D_GNU_SOURCE -O2 -g0 -ffp-contract=off -march=armv8-a -fopenmp -Wno-psabi -Itests/portable -I. -I$root/usr/include
    -I$root/usr/include/aarch64-linux-gnu -I$root/common"
mkdir -p $arm/objects
for source in $sources; do
    object=$arm/objects/${source//\//_}.o
    [ "$object" -nt "$source" ] || echo "$source $object"
done | xargs -r -P "$(nproc)" -L 1 sh -c "$cc $(echo $flags) -c \"\$0\" -o \"\$1\""
# shellcheck disable=SC2046
$cc -fopenmp -o $arm/tests $(for source in $sources; do echo "$arm/objects/${source//\//_}.o"; done) -L$libraries -Wl,-rpath-link,$libraries:$root/lib/aarch64-linux-gnu \
    -l:libgeos_c.so.1 -lminizip -lzip -lexpat -ljansson -lpng -lwebp -lassimp -lz -lm
echo "portable: tests under qemu-aarch64"
qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH="$PWD/$libraries:$PWD/$root/lib/aarch64-linux-gnu:/usr/aarch64-linux-gnu/lib" $arm/tests "$@"
