#!/bin/bash
# check_install.sh - what `make install` puts down is whole: the samples and the README's example are compiled against it, with the shared
# libraries and with the static ones, and run; every name has the prefix; manual page, completions, documentation.
case ${ENFILADE_BUILD:-build/release} in
*asan | *fuzz) exit 77 ;;  # programs of others are not linked with sanitizers
esac
. tests/app/checks.sh
compiler=$(cut -d' ' -f1 "$build/flags")
root=$work/root

env -u MAKEFLAGS -u MAKELEVEL make -s CC="$compiler" config="$(basename "$build")" PREFIX=/usr DESTDIR="$root" install \
    >"$work/log" 2>&1 || die "make install fails: $(tail -3 "$work/log")"
for file in bin/enfilade share/man/man1/enfilade.1 share/enfilade/house.plan include/enfilade/enfilade.h lib/libenfilade.a \
    lib/libenfilade.so lib/libenfilade-light.so lib/pkgconfig/enfilade.pc bin/enfilade-bench share/bash-completion/completions/enfilade; do
    [ -s "$root/usr/$file" ] || die "$file is not installed"
done
for home in flat.Home.xml hillside.sh3d villa.sh3d; do
    [ -s "$root/usr/share/enfilade/$home" ] || die "the sample $home is not installed"
done
# The terms of the font in the program: every line of its own notice, as the file of the font has it in UTF-16, is in the notices.
strings -e b -n 20 /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf | grep -iE 'copyright|notice|software|permission' >"$work/font"
[ "$(wc -l <"$work/font")" -ge 20 ] || die "the font's file tells no notice"
while read -r line; do
    grep -qF -- "$line" "$root/usr/share/enfilade/NOTICES" || die "the notices lack a line of the font's: $line"
done <"$work/font"
for name in cglm glad stb_truetype 'Khronos Group' 'Apache License'; do
    grep -q -- "$name" "$root/usr/share/enfilade/NOTICES" || die "the notices do not speak of $name"
done

# Programs of others: with the shared libraries and with the static ones, and as they run.
base_libs=$(sed -n 's/^Libs.private: //p' "$root/usr/lib/pkgconfig/enfilade.pc")
light_libs=$(sed -n 's/^Libs.private: //p' "$root/usr/lib/pkgconfig/enfilade-light.pc")
# compile SOURCE NAME: NAME.shared and NAME.static, both run on the smallest sample, with the same output in NAME.out.
compile() {
    local libs='-lenfilade -lm' archives=$root/usr/lib/libenfilade.a private=$base_libs
    if grep -q enfilade_light.h "$1"; then
        libs="-lenfilade-light $libs" archives="$root/usr/lib/libenfilade-light.a $archives" private="$light_libs $private"
    fi
    # shellcheck disable=SC2086
    $compiler -std=c11 -Wall -Wextra -Wpedantic -Werror -I"$root/usr/include" "$1" -L"$root/usr/lib" $libs -o "$work/$2.shared" ||
        die "$2 does not compile with the shared library"
    # shellcheck disable=SC2086
    $compiler -std=c17 -I"$root/usr/include" "$1" $archives $private -o "$work/$2.static" ||
        die "$2 does not compile with the static library"
    LD_LIBRARY_PATH=$root/usr/lib "$work/$2.shared" build/maps/two-rooms.plan >"$work/$2.out" || die "$2 fails"
    "$work/$2.static" build/maps/two-rooms.plan | cmp -s - "$work/$2.out" || die "$2: the two libraries differ"
}
for sample in tests/samples/*.c; do compile "$sample" "$(basename "$sample" .c)"; done
grep -q '^visible: 8 of 13 cells' "$work/see.out" && grep -q '^  parlour' "$work/see.out" || die "see says: $(cat "$work/see.out")"
grep -q '^from study through between to parlour' "$work/walk.out" || die "walk says: $(cat "$work/walk.out")"
grep -q '^light: [1-9]' "$work/light.out" && [ "$(grep -c '^at .*: 0\.[1-9]' "$work/light.out")" = 4 ] ||
    die "light says: $(cat "$work/light.out")"
[ "$(grep -c ': 3 of 3 cells' "$work/build.out")" = 2 ] || die "build says: $(cat "$work/build.out")"
LD_LIBRARY_PATH=$root/usr/lib "$work/see.shared" /nowhere.plan 2>"$work/err" && die "a missing building is no error"
grep -q nowhere.plan "$work/err" || die "a missing building is not named"
# The example of the README, and what it brings with it.
awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' README.md >"$work/example.c"
lines=$(wc -l <"$work/example.c")
[ "$lines" -ge 10 ] && [ "$lines" -le 40 ] || die "the README's example in C has $lines lines (10 to 40 are allowed)"
compile "$work/example.c" example
# It is C++ as well, in every version that compilers still take, with their warnings. The headers, which another check holds against C++17,
# are taken as the system's: as C they have literals that old C++ has not.
for version in c++11 c++17 c++20; do
    g++ -std=$version -Wall -Wpedantic -Werror -fsyntax-only -isystem "$root/usr/include" -x c++ "$work/example.c" 2>"$work/cpp" ||
        die "the README's example is no ${version^^}: $(grep -m1 error "$work/cpp")"
done
grep -q '^visible: [1-9]' "$work/example.out" || die "the example says: $(cat "$work/example.out")"
loaded=$(LD_LIBRARY_PATH=$root/usr/lib ldd "$work/example.shared" | wc -l)
# Three of them, and those that assimp brings, are for COLLADA and 3DS models.
[ "$loaded" -le 17 ] || die "the README's example loads $loaded libraries (17 are allowed)"

# Each header by itself, in C11 and in C++17.
while read -r header; do
    gcc -std=c11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I"$root/usr/include" -x c "$header" || die "$header is no C11"
    g++ -std=c++17 -Wall -Wextra -Werror -fsyntax-only -I"$root/usr/include" -x c++ "$header" || die "$header is no C++17"
done < <(find "$root/usr/include/enfilade" -name '*.h')

# A program that has all the short names for itself: what the libraries give away, and what the headers declare.
sed 's/ .*//' "$build/libenfilade.headers" | grep -v '_H$' | while read -r name; do
    case $name in
    [A-Z]*[a-z]*) echo "typedef struct $name { int own; } $name;" ;;
    [A-Z]*) echo "enum { $name = 1 };" ;;
    *) echo "int $name(void); int $name(void) { return 1; }" ;;
    esac
done >"$work/own.h"
printf '#include <enfilade/enfilade_light.h>\n#include "own.h"\nint main(void) { EnfArena a = {0}; enf_arena_free(&a); return 0; }\n' >"$work/own.c"
# shellcheck disable=SC2086
$compiler -std=c11 -I"$root/usr/include" "$work/own.c" "$root/usr/lib/libenfilade-light.a" "$root/usr/lib/libenfilade.a" $light_libs $base_libs \
    -o "$work/own" && "$work/own" || die 'names collide with those of a program'
for library in libenfilade libenfilade-light; do
    nm -D --defined-only "$root/usr/lib/$library.so" | awk '{ print $3 }' | grep -vE '^(enf_|ENF_|Enf)' && die "$library gives these names away"
    nm -g --defined-only "$root/usr/lib/$library.a" | awk 'NF == 3 { print $3 }' | grep -vE '^(enf_|ENF_|Enf)' && die "$library.a gives these names away"
done
nm -D --defined-only "$root/usr/lib/libenfilade.so" | grep -q ' enf_vis_query$' || die "vis_query is not exported"
nm -g "$build/radiosity/factors/row.o" | grep -q " T row_finish$" || die "row_finish is no name of the objects any more: take another"
nm -D --defined-only "$root/usr/lib/libenfilade-light.so" | grep -q row_finish && die "row_finish is exported"

# Completions ask the program; the manual is what the program says.
complete_with() {  # WORDS...
    PATH=$root/usr/bin:$PATH bash -c '. "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _enfilade; echo "${COMPREPLY[@]}"' \
        "$root/usr/share/bash-completion/completions/enfilade" "$@"
}
[ "$(complete_with enfilade wa)" = walk ] || die "wa is not completed: $(complete_with enfilade wa)"
[ "$(complete_with enfilade bake --fin)" = --final-gather ] || die "--fin is not completed"
[ "$(complete_with enfilade bake --method hemic)" = hemicube ] || die "hemic is not completed"
[ "$(complete_with enfilade bench hidden --methods war)" = warnock ] || die "war is not completed"
[ "$(complete_with enfilade bench visibility --methods pr)" = proof ] || die "pr is not completed"
for word in bake walk '\\-\\-final\\-gather'; do
    grep -q -- "$word" "$root/usr/share/man/man1/enfilade.1" || die "the manual does not speak of $word"
done
if command -v man >/dev/null && [ -e /usr/lib/man-db/man ]; then
    LC_ALL=C.UTF-8 MANROFFSEQ='' man --warnings -E UTF-8 -l "$root/usr/share/man/man1/enfilade.1" 2>"$work/man" >/dev/null
    [ -s "$work/man" ] && die "the manual has warnings: $(head -1 "$work/man")"
fi
if command -v doxygen >/dev/null; then
    env -u MAKEFLAGS -u MAKELEVEL make -s docs >"$work/docs" 2>&1 || die "make docs: $(head -3 "$work/docs")"
fi
exit 0
