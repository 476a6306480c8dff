#!/bin/bash
# check_commands.sh - the program as its user meets it: help, exit codes, messages, JSON, files written whole.
set -u
program=$ENFILADE_BUILD/enfilade
maps=build/maps
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME=$work/cache
bad=0
fail() { echo "check_commands: $*"; bad=1; }

# expect STATUS COMMAND...: runs it, output in $work/out and $work/err.
expect() {
    local status=$1
    shift
    "$@" >"$work/out" 2>"$work/err" </dev/null
    local got=$?
    [ $got -eq "$status" ] || fail "$* exits $got, not $status: $(head -2 "$work/err")"
}
says() { grep -q -- "$2" "$work/$1" || fail "no \`$2\` in $1: $(head -2 "$work/$1")"; }
quiet() { [ ! -s "$work/err" ] || fail "standard error should be empty: $(head -2 "$work/err")"; }

# Help everywhere, on standard output, with exit status 0.
expect 0 "$program" --help && says out 'usage'
for command in info vis plan walk bake bench; do
    expect 0 "$program" $command --help
    says out "usage: enfilade $command"
    quiet
done

# Wrong use: exit 2, what is wrong, and where help is.
expect 2 "$program"
expect 2 "$program" nonsense && says err 'there is no command `nonsense`'
expect 2 "$program" info && says err -- '--help'
expect 2 "$program" info --nonsense $maps/two-rooms.plan && says err '`--nonsense`'
expect 2 "$program" vis --threads 0 $maps/two-rooms.plan && says err 'allowed 1 to 256'
expect 2 "$program" vis --square 1e9 $maps/two-rooms.plan && says err 'allowed 0.25 to 100'
expect 2 "$program" plan --from 1,2 $maps/two-rooms.plan && says err 'X,Y,Z'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --size 0x0
expect 2 "$program" walk $maps/two-rooms.plan --verify && says err 'need --offscreen'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --view corner && says err 'for the window'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --look pretty && says err 'allowed fast, fine'
expect 2 "$program" bench nonsense
expect 2 "$program" vis --method nonsense $maps/two-rooms.plan && says err 'is `nonsense`'
expect 2 "$program" vis --seconds 0 $maps/two-rooms.plan && says err 'allowed 0.001 to 1e6'
expect 2 "$program" vis --pairs "$work/x.seen" -o "$work/x.vis" $maps/two-rooms.plan && says err 'allowed: --pairs'
expect 2 "$program" bench visibility --samples -1 $maps/two-rooms.plan && says err 'allowed 0 to 1000000'
expect 2 "$program" bench visibility --methods flood,nonsense $maps/two-rooms.plan && says err '`flood,nonsense`'
expect 2 "$program" bench formfactors --methods hemisphere,nonsense && says err '`hemisphere,nonsense`'
expect 2 "$program" bench formfactors --cullings most && says err '`most`'
expect 2 "$program" bench formfactors --resolutions 100,7 && says err '`100,7`'
expect 2 "$program" bake && says err 'one building file'
expect 2 "$program" bake --method nonsense $maps/two-rooms.plan && says err '`nonsense`'
expect 2 "$program" bake --resolution 7 $maps/two-rooms.plan && says err 'allowed 8 to 2000'
expect 2 "$program" bake --element 0 $maps/two-rooms.plan && says err 'allowed 0.01 to 100'
for wrong in --refine=-1 --refine=101 --refine=nan --smallest=0 --smallest=101 --reach=-1 --reach=x --reach=101 --close=-1 --close=2 --proxies=0 --proxies=1 --proxies=on; do
    expect 2 "$program" bake $wrong $maps/two-rooms.plan && says err "bake: ${wrong%=*} is"
done
expect 2 "$program" bake --residual 0 $maps/two-rooms.plan && says err 'allowed 1e-09 to 1'
for sky in x -1 1,2 1,2,3,4 1,2, 2e6 ''; do
    expect 2 "$program" bake --sky "$sky" $maps/two-rooms.plan && says err 'allowed L or R,G,B'
done
expect 2 "$program" bake --culling most $maps/two-rooms.plan && says err '`most`'
expect 2 "$program" bake --probe 1,2,3 $maps/two-rooms.plan && says err 'X,Y,Z,NX,NY,NZ'
expect 2 "$program" bake --probe 1,2,3,0,0,0 $maps/two-rooms.plan && says err 'a probe has no normal'
expect 2 "$program" bake --probe 1e9,2,3,0,0,1 $maps/two-rooms.plan && says err 'allowed: within 1e+08'
expect 2 "$program" bake --probe nan,2,3,0,0,1 $maps/two-rooms.plan && says err 'has the number nan'
expect 2 "$program" bake --method hemicube --hidden nonsense $maps/two-rooms.plan && says err '--hidden is `nonsense`'
expect 2 "$program" bake --hidden raycast $maps/two-rooms.plan && says err 'give --method hemicube'
expect 2 "$program" bench formfactors --methods hemicube-nonsense && says err '`hemicube-nonsense`'
expect 2 "$program" bench meshes --points 0 && says err 'allowed 1 to 1000000'
expect 2 "$program" bench hidden --methods zbuffer,nonsense && says err '`zbuffer,nonsense`'
# Bad input: exit 1 and one sentence with the place.
expect 1 "$program" info "$work/absent.plan" && says err 'absent.plan'
echo 'nonsense 1' >"$work/bad.plan"
expect 1 "$program" info "$work/bad.plan" && says err 'bad.plan:1'
# Without a display no window, but what to do instead.
expect 1 env -u DISPLAY -u WAYLAND_DISPLAY "$program" walk $maps/two-rooms.plan && says err '--offscreen'
expect 1 "$program" plan $maps/two-rooms.plan --from 1000,0,0 && says err 'no cell at'
[ "$(wc -l <"$work/err")" -eq 1 ] || fail "more than one sentence: $(cat "$work/err")"

# JSON: one object with the promised keys.
expect 0 "$program" info --json $maps/house.plan
for key in cells portals doors doors_joined polygons stab_nodes leaks; do says out "\"$key\": [0-9]"; done
expect 0 "$program" vis --json $maps/house.plan
for key in cells portals doors doors_joined polygons stab_nodes leaks; do says out "\"$key\": [0-9]"; done

# The same bytes on 1, 2 and 7 threads, on every sample.
for map in $maps/*.plan $maps/*.sh3d; do
    for threads in 1 2 7; do expect 0 "$program" vis "$map" -o "$work/$threads.vis" --threads $threads; done
    cmp -s "$work/1.vis" "$work/2.vis" && cmp -s "$work/1.vis" "$work/7.vis" || fail "$map: .vis depends on threads"
done

# A file that cannot be written: exit 1, nothing beside it, an earlier one kept.
cp "$work/1.vis" "$work/kept.vis"
expect 1 "$program" vis $maps/two-rooms.plan -o "$work/no/such/folder/x.vis" && says err 'cannot be written'
(trap '' XFSZ; ulimit -f 1; exec "$program" vis $maps/office.plan -o "$work/kept.vis") >/dev/null 2>"$work/err"
[ $? -eq 1 ] || fail 'a full disk went unseen'
says err 'cannot be written'
cmp -s "$work/1.vis" "$work/kept.vis" || fail 'an earlier file was lost'
[ "$(ls "$work" | grep -c '\.vis\..')" -eq 0 ] || fail 'a half-written file is left'
# The cache is used, and one that is damaged is passed over with a warning.
expect 0 "$program" info $maps/two-rooms.plan
cached=$(ls "$work"/cache/enfilade/*.vis | head -1)
for file in "$work"/cache/enfilade/*.vis; do printf 'x' | dd of="$file" bs=1 seek=200 conv=notrunc 2>/dev/null; done
expect 0 "$program" info $maps/two-rooms.plan && says err 'made anew'
[ -n "$cached" ] || fail 'nothing was cached'

# A cell-to-cell method: its matrix is the same on any number of threads, holds what is in it, and is compared.
for method in flood plan height flow proof; do
    for threads in 1 2 7; do
        expect 0 "$program" vis $maps/house.plan --method $method --pairs "$work/$threads.seen" --threads $threads
    done
    cmp -s "$work/1.seen" "$work/2.seen" && cmp -s "$work/1.seen" "$work/7.seen" || fail "$method depends on threads"
    expect 0 "$program" vis $maps/house.plan --method $method --against "$work/1.seen" && says out ' 0 missed; over 0.000 %'
done
expect 0 "$program" vis --json $maps/house.plan --against "$work/1.seen"
for key in cells portals pairs undecided misses over_percent seconds; do says out "\"$key\": [0-9]"; done
says out '"method": "proof"' && says out '"stopped": false'
expect 0 "$program" vis $maps/house.plan --method flood --pairs "$work/flood.seen"
expect 1 "$program" vis $maps/house.plan --method plan --against "$work/flood.seen" && says out 'missed first: cells'
expect 1 "$program" vis $maps/two-rooms.plan --against "$work/flood.seen" && says err 'is of 65 cells (expected 13)'
expect 1 "$program" vis $maps/two-rooms.plan --pairs "$work/no/such/folder/x.seen" && says err 'cannot be written'
# Stopped at once, by time or by hand, it still writes what errs towards visible.
expect 0 "$program" vis $maps/office.plan --seconds 0.001 --pairs "$work/early.seen" && says out 'stopped early'
expect 0 "$program" vis $maps/office.plan --pairs "$work/whole.seen"
expect 0 "$program" vis $maps/office.plan --method flood --against "$work/whole.seen"

# A compiler to compare with: one that fails, one that is no such program, one that writes what is asked for.
printf 'PRT1\n2\n1\n4 0 1 (0 0 9) (0 0 0) (0 9 0) (0 9 9)\n' >"$work/two.prt"
expect 1 "$program" vis "$work/two.prt" --peer /no/such/program && says err 'No such file'
printf '#!/bin/sh\necho "no leaves"; exit 3\n' >"$work/peer" && chmod +x "$work/peer"
expect 1 "$program" vis "$work/two.prt" --peer "$work/peer" && says err 'exit status 3: no leaves'
printf '#!/bin/sh\nexit 0\n' >"$work/peer"
expect 1 "$program" vis "$work/two.prt" --peer "$work/peer" && says err 'leaf 1 has no visibility'
expect 1 "$program" vis $maps/two-rooms.plan --peer "$work/peer" && says err 'is no PRT1 file'
cat >"$work/peer" <<'END'
#!/usr/bin/env python3
# Both leaves see both: a row of one byte, 3, at the end of the file; -threads N NAME.bsp.
import struct, sys
name = sys.argv[3]
level = bytearray(open(name, 'rb').read())
assert sys.argv[1] == '-threads' and open(name[:-3] + 'prt').read().startswith('PRT1')
leaves, = struct.unpack_from('<i', level, 4 + 8 * 10)
struct.pack_into('<ii', level, 4 + 8 * 4, len(level), 1)
for leaf in 1, 2:
    struct.pack_into('<i', level, leaves + 28 * leaf + 4, 0)
open(name, 'wb').write(level + b'\3')
END
if python3 -c '' 2>/dev/null; then
    expect 0 "$program" vis "$work/two.prt" --peer "$work/peer" && says out 'peer: 2.00 cells in the mean'
    expect 0 "$program" bench visibility "$work/two.prt" --peer "$work/peer" --csv "$work/bench.csv"
    cmp -s "$work/out" "$work/bench.csv" || fail 'the table in the file is another'
    grep -q '^two.prt,peer,2,1,.*,4,4,4,0.0000,0.0000,0,' "$work/bench.csv" || fail "peer: $(tail -1 "$work/bench.csv")"
fi
[ -z "$(ls "${TMPDIR:-/tmp}" | grep '^enfilade-peer-')" ] || fail 'a folder of a compiler is left'

# The table: a row a method, no misses, and the compiler's skipped where none is given.
expect 0 "$program" bench visibility $maps/two-rooms.plan --methods flood,proof --samples 4
[ "$(wc -l <"$work/out")" -eq 4 ] || fail "rows of the table: $(cat "$work/out")"
[ "$(awk -F, 'NR > 1 { print NF }' "$work/out" | sort -u)" = 21 ] || fail 'rows of different length'
[ "$(awk -F, '$2 != "peer" && NR > 1 { print $15 }' "$work/out" | sort -u)" = 0 ] || fail 'misses'
says out 'two-rooms.plan,peer,13,24,skipped,.*no --peer was given'

# A hemicube filled by each hidden-surface method sees what it sees by itself: errors within a tenth.
expect 0 "$program" bench formfactors $maps/two-rooms.plan --methods hemicube,hemicube-raycast,hemicube-osmesa \
    --resolutions 50 --cullings none --shooters 5 --rays 100000
[ "$(awk -F, 'NR > 1 { print $2 }' "$work/out" | tr '\n' ' ')" = 'hemicube hemicube-raycast hemicube-osmesa ' ] ||
    fail "rows of hidden surfaces: $(cat "$work/out")"
awk -F, 'NR == 2 { l1 = $8 } NR > 2 && ($8 > 1.1 * l1 || $8 < 0.9 * l1) { exit 1 }' "$work/out" ||
    fail "hidden surfaces err otherwise: $(cat "$work/out")"

# Light: the promised keys, the same bytes on any number of threads, with whatever memory, culled or not; the help's methods.
bake() { expect "$1" "$program" bake $maps/two-rooms.plan --element 0.5 --resolution 50 --residual 0.05 "${@:2}"; }
bake 0 -o "$work/1.rad" --threads 1 --json --probe 1,1,0,0,0,1
for key in polygons patches elements shots residual elements_drawn_mean polygons_drawn_mean seconds seconds_visibility peak_mb
do says out "\"$key\": [0-9]"; done
says out '"probes": \['
bake 0 -o "$work/2.rad" --threads 2 --row-memory 0
bake 0 -o "$work/7.rad" --threads 7 --row-memory 1
bake 0 -o "$work/none.rad" --no-cull
for rad in 2 7 none; do cmp -s "$work/1.rad" "$work/$rad.rad" || fail ".rad differs: $rad"; done
printf '# a point\n1 1 0 0 0 1\n' >"$work/points"
bake 0 -o "$work/1.rad" --probes "$work/points" --probe 1,1,1,0,0,-1
[ "$(awk 'NF == 12 && $7 > 0' "$work/out" | wc -l)" -eq 2 ] || fail "two probes are $(tail -2 "$work/out")"
printf '1 1 0 0 1\n' >"$work/points"
bake 1 -o "$work/1.rad" --probes "$work/points" && says err 'points:1'
# Broken off and resumed, it ends the same; what does not fit is refused.
bake 0 -o "$work/part.rad" --shots 100 && says out 'shots  *100'
bake 0 -o "$work/part.rad" --resume
cmp -s "$work/1.rad" "$work/part.rad" || fail 'a resumed bake ends otherwise'
bake 1 -o "$work/part.rad" --resume --per-patch 1 && says err 'asked for: 0.5 m, 1'
bake 1 -o "$work/part.rad" --resume --doors open && says err 'was made with door'
bake 1 -o "$work/part.rad" --resume --sky 5 && says err 'was made under a sky of 0,0,0'
bake 0 -o "$work/gathered.rad" --final-gather --threads 1 --json && says out '"nodes": [1-9]'
bake 0 -o "$work/gathered.2.rad" --final-gather --threads 2
cmp -s "$work/gathered.rad" "$work/gathered.2.rad" || fail 'the final gather depends on threads'
expect 0 "$program" walk $maps/two-rooms.plan --light "$work/gathered.rad" --offscreen "$work/gathered" --size 64x48 --every 1000
bake 0 -o "$work/gathered.rad" --resume
cmp -s "$work/gathered.rad" "$work/1.rad" || fail 'a resumed bake keeps what was gathered before'
# A model beside the light or instead of it; whole or not at all.
bake 0 -o "$work/both.rad" -o "$work/both.GLB" && says out 'model  *.*both.GLB'
cmp -s "$work/both.rad" "$work/1.rad" || fail 'a model changes the light'
bake 0 -o "$work/one.glb" --threads 3 && cmp -s "$work/one.glb" "$work/both.GLB" || fail 'models differ'
[ -z "$(ls "$work"/cache/enfilade/*.rad 2>/dev/null)" ] || fail 'a model asked for alone leaves light in the cache'
expect 0 "$program" info "$work/one.glb" && says out 'polygons'
bake 1 -o "$work/no/such/folder/x.glb" && says err 'cannot be written'
(trap '' XFSZ; ulimit -f 8; exec "$program" bake $maps/two-rooms.plan -o "$work/one.glb") >/dev/null 2>"$work/err"
[ $? -eq 1 ] || fail 'a full disk went unseen by a model'
cmp -s "$work/one.glb" "$work/both.GLB" || fail 'an earlier .glb file was lost'
bake 1 -o "$work/absent.rad" --resume && says err 'absent.rad: cannot be opened'
printf 'x' | dd of="$work/part.rad" bs=1 seek=2000 conv=notrunc 2>/dev/null
bake 1 -o "$work/part.rad" --resume && says err 'its checksum is wrong'
head -c 3000 "$work/1.rad" >"$work/short.rad" && head -c 100 "$work/1.rad" >"$work/stub.rad"
head -c 5000 /dev/zero >"$work/other.rad"
shown() { expect 1 "$program" walk "$1" --light "$work/$2.rad" --offscreen "$work/lit" && says err "$3"; }
for way in resume show; do
    while read -r file said; do
        [ $way = show ] && shown $maps/two-rooms.plan "$file" "$said"
        [ $way = resume ] && bake 1 -o "$work/$file.rad" --resume && says err "$said"
    done <<'END'
part its checksum is wrong
short has 3000 bytes (its header says
stub has 100 bytes, less than a .rad header
other is not a .rad file
absent cannot be opened
END
done
shown $maps/house.plan 1 'belongs to another building'
# No light, an open building, an element for each grain of sand.
printf 'quad a .5 0 0 0 0 1 0 0 1 1 0 0 1 0\n' >"$work/dark.quads"
expect 1 "$program" bake "$work/dark.quads" -o "$work/x.rad" && says err 'nothing emits light'
printf 'quad a .5 1 0 0 0 1 0 0 1 1 0 0 1 0\n' >"$work/open.quads"
expect 0 "$program" bake "$work/open.quads" -o "$work/x.rad" && says err 'is open: 100 % of its light escaped'
expect 0 "$program" bake "$work/dark.quads" --sky 5 -o "$work/x.rad" && says out 'sky  *[1-9]'
expect 1 "$program" bake "$work/two.prt" -o "$work/x.rad" && says err 'without walls'
# Surfaces that cannot be, each with its line; those that are mended are told of.
lamp='quad l 0 5 0 0 2 0 1 2 1 1 2 1 0 2'
bad_quad() { # STATUS, what is said, a quad
    printf '%s\n%s\n' "$lamp" "$3" >"$work/odd.quads"
    expect "$1" "$program" bake "$work/odd.quads" --element 0.5 -o "$work/x.rad" && says err "$2"
}
floor='0 0 0 1 0 0 1 1 0 0 1 0'
bad_quad 1 'odd.quads:2: the reflectance is `-0.1` (allowed 0 to 1)' "quad a -0.1 0 $floor"
bad_quad 1 'odd.quads:2: the reflectance is `1.5` (allowed 0 to 1)' "quad a 1.5 0 $floor"
bad_quad 1 'odd.quads:2: the reflectance is `nan` (allowed 0 to 1)' "quad a nan 0 $floor"
bad_quad 1 'odd.quads:2: the exitance is `-1`' "quad a .5 -1 $floor"
bad_quad 1 'odd.quads:2: the exitance is `inf`' "quad a .5 inf $floor"
bad_quad 1 'odd.quads:2: the quad a has an area of 0' 'quad a .5 0 0 0 0 1 0 0 1 0 0 0 0 0'
bad_quad 0 'reflect more than 0.85 and were capped, `a` first; the most was 1' "quad a 1 0 $floor"
bad_quad 0 '1 quads are bent or concave and were cut' 'quad a .5 0 0 0 0 1 0 0 1 1 0.5 0 1 0'
bad_quad 0 '1 quads are bent or concave and were cut' 'quad a .5 0 0 0 0 1 0 0 0.2 0.2 0 0 1 0'
bad_plan() { # what is said, a line
    printf 'plan 1\n%s\n' "$2" >"$work/odd.plan"
    expect 1 "$program" bake "$work/odd.plan" -o "$work/x.rad" && says err "odd.plan:2: $1"
}
bad_plan 'reflectance is .1.' 'material a reflectance 1'
bad_plan 'reflectance is .-0.5.' 'material a reflectance -0.5'
bad_plan 'reflectance is .nan.' 'material a reflectance nan'
bad_plan 'emission is .nan.' 'material a #ffffff emission nan'
bad_plan 'emission is .-1.' 'material a #ffffff emission -1'
expect 1 "$program" bake $maps/office.plan --element 0.01 -o "$work/x.rad" && says err 'give --element'
# Whatever happens, an earlier file is kept: no folder, a full disk, killed at any moment.
bake 1 -o "$work/no/such/folder/x.rad" && says err 'cannot be written'
bake 1 -o "$work" && says err 'Is a directory'
bake 1 -o /dev/full && says err 'No space left'
[ -c /dev/full ] || fail 'a device was replaced by a file'
(trap '' XFSZ; ulimit -f 1; exec "$program" bake $maps/two-rooms.plan -o "$work/1.rad") >/dev/null 2>"$work/err"
[ $? -eq 1 ] || fail 'a full disk went unseen'
says err 'cannot be written'
cmp -s "$work/1.rad" "$work/2.rad" || fail 'an earlier .rad file was lost'
for wait in 0.01 0.02 0.03 0.05 0.08 0.12 0.2; do
    "$program" bake $maps/two-rooms.plan -o "$work/1.rad" --element 0.5 --resolution 50 --residual 0.05 >/dev/null 2>&1 &
    sleep $wait
    kill -KILL $! 2>/dev/null
    wait $! 2>/dev/null
    cmp -s "$work/1.rad" "$work/2.rad" || fail "killed after $wait s, it left a broken file"
done
rm -f "$work"/1.rad.??????
# Interrupted, it stores what there is.
"$program" bake $maps/office-plain.plan -o "$work/early.rad" --json >"$work/out" 2>"$work/err" &
sleep 1.5
kill -INT $!
wait $! || fail 'an interrupted bake fails'
says out '"stopped": '
expect 0 "$program" bake $maps/office-plain.plan -o "$work/early.rad" --resume --seconds 0.01
# Lamps of a home give light.
expect 0 "$program" bake $maps/house.sh3d -o "$work/x.rad" --element 1 --resolution 50 --residual 0.2
expect 0 "$program" bake $maps/two-rooms.plan --element 1
cached=$(ls "$work"/cache/enfilade/*.rad) || fail 'no light in the cache'
# It is shown from there as if it were given, if it is whole; a file beside the building that does not fit is told of, too.
cp $maps/two-rooms.plan "$work/lit.plan"
show() { expect 0 "$program" walk "$work/lit.plan" --offscreen "$work/$1" --size 64x64 --step 10 --turn 60 "${@:2}"; }
show given --light "$cached" && quiet
show found && quiet
cmp -s "$work/given/frame-00000.png" "$work/found/frame-00000.png" || fail 'the light in the cache is not shown'
cp "$work/short.rad" "$work/lit.rad"
show beside && says err 'passed over: .*/lit.rad: has 3000 bytes'
cmp -s "$work/given/frame-00000.png" "$work/beside/frame-00000.png" || fail 'the light in the cache is not shown instead'
cp "$work/short.rad" "$cached" && rm "$work/lit.rad"
show dark && says err "passed over: $cached: has 3000 bytes"
cmp -s "$work/given/frame-00000.png" "$work/dark/frame-00000.png" && fail 'damaged light is shown'

# The plan is well-formed SVG with the tree's rooms.
expect 0 "$program" plan $maps/two-rooms.plan -o "$work/plan.svg" --from 1,1,1.5
grep -q '</svg>' "$work/plan.svg" || fail 'the plan is no SVG'
exit $bad
