#!/bin/bash
# check_install.sh - what `make install` puts down is whole: the README's example is compiled against it, with the shared library and
# with the static one, and run; the libraries give away the names of their headers alone; manual page, completions, documentation.
case ${ENFILADE_BUILD:-build/release} in
*asan | *fuzz) exit 77 ;;  # programs of others are not linked with sanitizers
esac
. tests/app/checks.sh
compiler=$(cut -d' ' -f1 "$build/flags")
root=$work/root

env -u MAKEFLAGS -u MAKELEVEL make -s CC="$compiler" config="$(basename "$build")" PREFIX=/usr DESTDIR="$root" install \
    >"$work/log" 2>&1 || die "make install fails: $(tail -3 "$work/log")"
for file in bin/enfilade share/man/man1/enfilade.1 share/enfilade/house.plan include/enfilade/enfilade.h lib/libenfilade.a \
    lib/libenfilade.so lib/pkgconfig/enfilade.pc share/bash-completion/completions/enfilade; do
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

# The example of the README.
awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' README.md >"$work/example.c"
[ "$(wc -l <"$work/example.c")" -ge 10 ] || die "the README has no example in C"
[ "$(wc -l <"$work/example.c")" -le 40 ] || die "the README's example has more than 40 lines"
libs=$(sed -n 's/^Libs.private: //p' "$root/usr/lib/pkgconfig/enfilade.pc")
$compiler -std=c17 -Wall -Wextra -Werror -I"$root/usr/include" "$work/example.c" -L"$root/usr/lib" -lenfilade \
    -o "$work/shared" || die "the example does not compile with the shared library"
# shellcheck disable=SC2086
$compiler -std=c17 -I"$root/usr/include" "$work/example.c" "$root/usr/lib/libenfilade.a" $libs -o "$work/static" ||
    die "the example does not compile with the static library"
LD_LIBRARY_PATH=$root/usr/lib "$work/shared" build/maps/two-rooms.plan >"$work/shared.out" || die "the example fails"
"$work/static" build/maps/two-rooms.plan >"$work/static.out" || die "the static example fails"
cmp -s "$work/shared.out" "$work/static.out" || die "the two libraries differ"
grep -q '^visible: [1-9]' "$work/shared.out" && grep -q '^light: [1-9]' "$work/shared.out" ||
    die "the example says: $(cat "$work/shared.out")"
LD_LIBRARY_PATH=$root/usr/lib "$work/shared" /nowhere.plan 2>"$work/err" && die "a missing building is no error"
grep -q nowhere.plan "$work/err" || die "a missing building is not named"
echo '#include <enfilade/enfilade.h>' | g++ -fsyntax-only -x c++ -I"$root/usr/include" - || die "the headers are none for C++"

# No name but those of the headers.
nm -D --defined-only "$root/usr/lib/libenfilade.so" | awk '{ print $3 }' | LC_ALL=C sort >"$work/shared.names"
nm -g --defined-only "$root/usr/lib/libenfilade.a" | awk 'NF == 3 { print $3 }' | LC_ALL=C sort >"$work/static.names"
cmp -s "$work/shared.names" "$work/static.names" || die "the libraries give away different names"
grep -qx vis_query "$work/shared.names" || die "vis_query is not exported"
nm -g "$build/radiosity/factors/row.o" | grep -q " T row_finish$" || die "row_finish is no name of the objects any more: take another"
grep -qx row_finish "$work/shared.names" && die "row_finish is exported"

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
