#!/bin/bash
# check_commands.sh - the program as its user meets it: help, exit codes, messages, JSON, files written whole. Light has a script of its
# own, check_bake.sh, and so have stills, check_render.sh.
. tests/app/checks.sh

# Help everywhere, on standard output, with exit status 0.
expect 0 "$program" --help && says out 'usage'
for command in $("$program" --help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    expect 0 "$program" $command --help
    says out "usage: enfilade $command"
    quiet
done

# Wrong use: exit 2, what is wrong, and where help is.
expect 2 "$program"
expect 2 "$program" nonsense && says err 'there is no command `nonsense`'
for typo in wlak:walk rendr:render bkae:bake pln:plan; do
    expect 2 "$program" "${typo%:*}" && says err "there is no command .${typo%:*}.; .${typo#*:}. may be meant"
done
for word in nonsense w x; do
    expect 2 "$program" $word
    grep -q meant "$work/err" && fail "$word is taken for a command: $(head -1 "$work/err")"
done
for wrong in "vis -o x.rad" "plan -o x.png"; do
    expect 2 "$program" ${wrong%% *} $maps/two-rooms.plan -o "$work/${wrong##* }" && says err 'allowed names that end in'
done
expect 2 "$program" info && says err '--help'
expect 2 "$program" info --nonsense $maps/two-rooms.plan && says err '`--nonsense`'
expect 2 "$program" vis --threads 0 $maps/two-rooms.plan && says err 'allowed 1 to 256'
for command in info vis plan walk bake light render "bench walk"; do
    for wrong in 15 1000001 12x ''; do
        expect 2 "$program" $command $maps/two-rooms.plan --memory "$wrong" && says err "allowed 16 to 1000000"
    done
done
expect 2 "$program" vis --square 1e9 $maps/two-rooms.plan && says err 'allowed 0.25 to 100'
expect 2 "$program" plan --from 1,2 $maps/two-rooms.plan && says err 'X,Y,Z'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --size 0x0
expect 2 "$program" walk $maps/two-rooms.plan --verify && says err 'need --offscreen'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --view corner && says err 'for the window'
expect 2 "$program" walk $maps/two-rooms.plan --offscreen "$work/x" --look pretty && says err 'allowed fast, fine'
# Each benchmark that there is tells what it measures.
expect 2 "$program" bench nonsense && says err 'no benchmark `nonsense` (allowed: walk, '
for bench in $(sed -n 's/.*(allowed: \(.*\))$/\1/p' "$work/err" | tr -d ,); do
    expect 0 "$program" bench --help && says out "^  $bench  "
done
expect 2 "$program" vis --pairs-method nonsense $maps/two-rooms.plan && says err 'is `nonsense`'
expect 2 "$program" vis --seconds 0 $maps/two-rooms.plan && says err 'allowed 0.001 to 1000000'
expect 2 "$program" vis --pairs "$work/x.seen" -o "$work/x.vis" $maps/two-rooms.plan && says err 'allowed: --pairs'
expect 2 "$program" bench visibility --samples -1 $maps/two-rooms.plan && says err 'allowed 0 to 1000000'
expect 2 "$program" bench visibility --methods flood,nonsense $maps/two-rooms.plan && says err '`flood,nonsense`'
expect 2 "$program" bench formfactors --methods hemisphere,nonsense && says err '`hemisphere,nonsense`'
expect 2 "$program" bench walk --methods stab && says err 'no option `--methods`'
expect 2 "$program" bench walk --steps 3 && says err 'no option `--steps`'
expect 2 "$program" bench formfactors --cullings most && says err '`most`'
expect 2 "$program" bench formfactors --resolutions 100,7 && says err '`100,7`'
expect 2 "$program" bake && says err 'one building file'
expect 2 "$program" light && says err 'one building file'
expect 2 "$program" light --plane -1 $maps/two-rooms.plan && says err 'allowed 0 to 100'
expect 2 "$program" light --sky blue $maps/two-rooms.plan && says err 'allowed overcast, uniform, none'
expect 2 "$program" light --outside 0 $maps/two-rooms.plan && says err 'allowed 1 to 200000'
expect 2 "$program" light --svg x.png $maps/two-rooms.plan && says err 'svg'
expect 1 "$program" light --plane 50 $maps/two-rooms.plan && says err 'no room is higher than the working plane, 50 m'
expect 1 "$program" light --lamps off --sky none $maps/two-rooms.plan && says err 'all lamps are off, and there is no sky'
expect 1 "$program" light tests/seeds/two-cells.prt && says err 'no rooms are told apart'
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
for date in x 2026 2026-13-01 2026-02-29 1899-01-01 2026-06-21x ''; do
    expect 2 "$program" bake --date "$date" $maps/two-rooms.plan && says err 'allowed YYYY-MM-DD, years 1900 to 2100'
done
for time in x 10 24:00 10:60 -1:00 10:00x 10:00+15 ''; do
    expect 2 "$program" bake --time "$time" $maps/two-rooms.plan && says err 'allowed HH:MM, or HH:MM+H'
done
for place in x 50 91,0 0,181 nan,0 50,0,0 ''; do
    expect 2 "$program" bake --place "$place" $maps/two-rooms.plan && says err 'allowed degrees north and east'
done
expect 2 "$program" bake --north 361 $maps/two-rooms.plan && says err 'allowed -360 to 360'
expect 2 "$program" bake --weather rain $maps/two-rooms.plan && says err 'allowed clear, intermediate, overcast'
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
for key in cells portals doors doors_joined polygons leaks; do says out "\"$key\": [0-9]"; done
expect 0 "$program" vis --json $maps/house.plan
for key in cells portals doors doors_joined polygons stab_nodes leaks; do says out "\"$key\": [0-9]"; done

# Too little memory: one sentence that names the file, the stage and the way out; nothing is written.
over() {
    expect 1 "$program" "$@" && sentence
    says err "^enfilade: $maps/[a-z0-9.]*: $stage takes more than [0-9]* MB of memory (--memory MB allows more)\$"
    [ ! -e "$work/over" ] || fail "$* left something"
}
stage='reading'
over info $maps/hillside.sh3d --memory 28
over vis $maps/hillside.sh3d --memory 28 -o "$work/over"
over vis $maps/hillside.sh3d --memory 28 --pairs "$work/over"
over plan $maps/hillside.sh3d --memory 28 -o "$work/over"
over render $maps/hillside.sh3d --memory 28 -o "$work/over"
over bench walk $maps/hillside.sh3d --memory 28
over walk $maps/hillside.sh3d --memory 28 --offscreen "$work/over"
stage='making cells'
over info $maps/villa.sh3d --memory 28
stage=baking
over bake $maps/house.plan --memory 80 -o "$work/over"
expect 1 "$program" bake $maps/house.plan --memory 80 --element 0.1 --final-gather -o "$work/over" && sentence && says err "its light, about 4.4e+05 elements, takes more memory than there is"
expect 0 "$program" info $maps/office.plan --memory 1000

# The same bytes on 1, 2 and 7 threads, on every sample.
# Not all that lies there: `make bench` leaves rows of a thousand rooms.
for map in $maps/{two-rooms,house,office,office-plain}.plan $maps/house.sh3d; do
    for threads in 1 2 7; do expect 0 "$program" vis "$map" -o "$work/$threads.vis" --threads $threads; done
    cmp -s "$work/1.vis" "$work/2.vis" && cmp -s "$work/1.vis" "$work/7.vis" || fail "$map: .vis depends on threads"
done

# A file that cannot be written: exit 1, nothing beside it, an earlier one kept.
cp "$work/1.vis" "$work/kept.vis"
expect 1 "$program" vis $maps/two-rooms.plan -o "$work/no/such/folder/x.vis" && says err 'cannot be written'
full_disk 1 "$program" vis $maps/office.plan -o "$work/kept.vis"
[ $? -eq 1 ] || fail 'a full disk went unseen'
says err 'cannot be written'
same "$work/1.vis" "$work/kept.vis" 'an earlier file was lost'
[ "$(ls "$work" | grep -c '\.vis\..')" -eq 0 ] || fail 'a half-written file is left'
# The cache is used, and one that is damaged is passed over with a warning.
expect 0 "$program" plan $maps/two-rooms.plan -o "$work/plan.svg"
cached=$(ls "$work"/cache/enfilade/*.vis | head -1)
for file in "$work"/cache/enfilade/*.vis; do printf 'x' | dd of="$file" bs=1 seek=200 conv=notrunc 2>/dev/null; done
expect 0 "$program" plan $maps/two-rooms.plan -o "$work/plan.svg" && says err 'made anew'
[ -n "$cached" ] || fail 'nothing was cached'
rm "$work"/cache/enfilade/*.vis  # other buildings' are damaged still

# A cell-to-cell method: its matrix is the same on any number of threads, holds what is in it, and is compared.
for method in flood plan height flow proof; do
    for threads in 1 2 7; do
        expect 0 "$program" vis $maps/house.plan --pairs-method $method --pairs "$work/$threads.seen" --threads $threads
    done
    cmp -s "$work/1.seen" "$work/2.seen" && cmp -s "$work/1.seen" "$work/7.seen" || fail "$method depends on threads"
    expect 0 "$program" vis $maps/house.plan --pairs-method $method --against "$work/1.seen" && says out ' 0 missed; over 0.000 %'
done
expect 0 "$program" vis --json $maps/house.plan --against "$work/1.seen"
for key in cells portals pairs undecided misses over_percent seconds; do says out "\"$key\": [0-9]"; done
says out '"method": "proof"' && says out '"stopped": false'
expect 0 "$program" vis $maps/house.plan --pairs-method flood --pairs "$work/flood.seen"
expect 1 "$program" vis $maps/house.plan --pairs-method plan --against "$work/flood.seen" && says out 'missed first: cells'
expect 1 "$program" vis $maps/two-rooms.plan --against "$work/flood.seen" && says err 'is of 65 cells (expected 13)'
expect 1 "$program" vis $maps/two-rooms.plan --pairs "$work/no/such/folder/x.seen" && says err 'cannot be written'
# Stopped at once, by time or by hand, it still writes what errs towards visible.
expect 0 "$program" vis $maps/office.plan --seconds 0.001 --pairs "$work/early.seen" && says out 'stopped early'
expect 0 "$program" vis $maps/office.plan --pairs "$work/whole.seen"
expect 0 "$program" vis $maps/office.plan --pairs-method flood --against "$work/whole.seen"

# A compiler to compare with: one that fails, one that is no such program, one that writes what is asked for.
mkdir "$work/tmp" && export TMPDIR=$work/tmp
printf 'PRT1\n2\n1\n4 0 1 (0 0 9) (0 0 0) (0 9 0) (0 9 9)\n' >"$work/two.prt"
expect 0 "$program" bench visibility "$work/two.prt" --peer /no/such/program && says out 'No such file'
printf '#!/bin/sh\necho "no leaves"; exit 3\n' >"$work/peer" && chmod +x "$work/peer"
expect 0 "$program" bench visibility "$work/two.prt" --peer "$work/peer" && says out 'exit status 3: no leaves'
printf '#!/bin/sh\nexit 0\n' >"$work/peer"
expect 0 "$program" bench visibility "$work/two.prt" --peer "$work/peer" && says out 'leaf 1 has no visibility'
expect 0 "$program" bench visibility $maps/two-rooms.plan --peer "$work/peer" && says out 'is no PRT1 file'
# Building models, the same on one thread and on all, beside a program that does nothing.
expect 0 "$program" bench models tests/seeds/small.ifc --peer "$work/peer" && says out ',one-thread,1,0.00,' &&
    says out ',all-threads,0,0.00,' && says out 'small.ifc,peer,.*,peer'
expect 2 "$program" bench models --methods two-threads && says err '`two-threads`'
expect 1 "$program" bench models $maps/two-rooms.plan && says err 'is no STEP file'
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
    expect 0 "$program" bench visibility "$work/two.prt" --peer "$work/peer" --csv "$work/bench.csv"
    same "$work/out" "$work/bench.csv" 'the table in the file is another'
    grep -q '^two.prt,peer,2,1,.*,4,4,4,0.0000,0.0000,0,' "$work/bench.csv" || fail "peer: $(tail -1 "$work/bench.csv")"
fi

# An occlusion culler to compare with: one that answers nothing, one that names objects that are not there, one that draws all.
printf '#!/bin/sh\necho >"$2"\n' >"$work/culler" && chmod +x "$work/culler"
expect 1 "$program" bench walk $maps/two-rooms.plan --frames 3 --peer "$work/culler" && says err 'answer 0 is no time'
printf '#!/bin/sh\necho 1 0 100000 >"$2"\n' >"$work/culler"
expect 1 "$program" bench walk $maps/two-rooms.plan --frames 3 --peer "$work/culler" && says err 'is `100000` (allowed: 1 to'
printf '#!/bin/sh\necho 1 5 5 >"$2"\n' >"$work/culler"
expect 1 "$program" bench walk $maps/two-rooms.plan --frames 3 --peer "$work/culler" && says err 'is `5` (allowed: 6 to'
cat >"$work/culler" <<'END'
#!/bin/sh
awk '$1 == "object" { all = all " " n++ } $1 == "polygon" { used[n - 1] = 1 }
     $1 == "frame" { line = 2500; for (i = 0; i < n; i++) if (used[i]) line = line " " i; print line }' "$1" >"$2"
END
expect 0 "$program" bench walk $maps/two-rooms.plan --frames 3 --peer "$work/culler"
[ "$(awk -F, '$2 == "none" { n = $5 } $2 == "peer" { print $5 - n, $7, $13 }' "$work/out")" = '0 2500.00 2500.00' ] ||
    fail "an occlusion culler that draws all: $(tail -1 "$work/out")"
[ -z "$(ls "$TMPDIR" | grep '^enfilade-peer-')" ] || fail 'a folder of a compiler is left'

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

# The sample homes are those that their script draws: the same entries, whatever the compression made of them.
mkdir "$work/homes" && python3 maps/buildings/homes.py "$work/homes" || fail 'homes.py fails'
python3 - "$work/homes" maps/buildings <<'END' || fail 'a sample home is not what homes.py draws: make house'
import os, sys, zipfile
def entries(path):
    if not path.endswith('.sh3d'):
        return open(path, 'rb').read()
    with zipfile.ZipFile(path) as home:
        return {name: home.read(name) for name in home.namelist() if name != 'ContentDigests' and not name.endswith('.png')}
sys.exit(any(entries(os.path.join(sys.argv[1], n)) != entries(os.path.join(sys.argv[2], n)) for n in os.listdir(sys.argv[1])))
END

# The plan is well-formed SVG with the tree's rooms.
expect 0 "$program" plan $maps/two-rooms.plan -o "$work/plan.svg" --from 1,1,1.5
grep -q '</svg>' "$work/plan.svg" || fail 'the plan is no SVG'

# Without a place for a cache, in a read-only one, on a full disk, all commands work and say so once, before the work; only `vis`, which
# stores and does nothing else, fails. What a bake makes is shown and drawn all the same.
two=$maps/two-rooms.plan
rough='--element 1 --close 0 --reach 0 --refine 0 --residual 0.05 --resolution 50'
touch "$work/file"
without_cache() { # how many of the commands, what is said, a way to run one without a cache
    local most=$1 said=$2
    shift 2
    rm -rf "$work/none"
    while read -r status command; do
        expect "$status" "$@" "$program" ${command//OUT/$work/none}
        says err "$said"
        [ "$(grep -c -e 'not kept' -e 'cannot be stored' "$work/err")" -eq 1 ] || fail "$*: $command: says $(cat "$work/err")"
    done < <(head -n "$most" <<END
0 plan $two -o OUT.svg
1 vis $two
0 bake $two $rough
0 bake $two $rough -o OUT.rad
0 walk $two --offscreen OUT --tour window --size 64x36 --bake --night
0 render $two --size 32x18 --samples 1 -o OUT.png
0 bench collision $two --steps 10
END
)
    expect 0 "$@" "$program" vis $two -o "$work/none.vis" && quiet
    expect 1 "$@" "$program" bake $two --resume && says err 'give -o OUT.rad\|cannot be opened'
}
without_cache 7 'neither XDG_CACHE_HOME nor HOME is set' env -u HOME -u XDG_CACHE_HOME
for file in .svg .rad .png /frame-00000.png; do [ -s "$work/none$file" ] || fail "none$file was not written"; done
cp "$work/none/frame-00000.png" "$work/lit.png"
expect 0 env -u HOME -u XDG_CACHE_HOME "$program" walk $two --offscreen "$work/none" --tour window --size 64x36
cmp -s "$work/none/frame-00000.png" "$work/lit.png" && fail 'a walk that bakes without a cache is unlit'
expect 0 env -u XDG_CACHE_HOME HOME="$work/home" "$program" plan $two -o "$work/plan.svg" && quiet
[ -d "$work/home/.cache/enfilade" ] || fail 'no cache in HOME'
expect 0 env XDG_CACHE_HOME=relative HOME="$work/home" "$program" plan $two -o "$work/plan.svg" && quiet
[ ! -e relative ] || fail 'a relative XDG_CACHE_HOME was used'
without_cache 3 'file/enfilade: cannot be made: Not a directory' env XDG_CACHE_HOME="$work/file"
if unshare -rm true 2>/dev/null; then
    # What lies in a read-only cache is used; on a full one there is no room.
    mkdir -p "$work/still/enfilade"
    in_mount() { unshare -rm bash -c 'mount -t tmpfs -o "$1" none "$2" && shift 2 && exec "$@"' mount "$@"; }
    without_cache 3 'Read-only file system' in_mount ro "$work/still" env XDG_CACHE_HOME="$work/still"
    without_cache 3 'No space left' in_mount size=4k,nr_inodes=2 "$work/still" env XDG_CACHE_HOME="$work/still"
    cp "$work"/home/.cache/enfilade/* "$work/still/enfilade"
    read_only() { unshare -rm bash -c 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && shift && exec "$@"' mount "$@"; }
    expect 0 read_only "$work/still" env XDG_CACHE_HOME="$work/still" "$program" plan $two -o "$work/plan.svg" && quiet
fi

# What is no regular file is refused at once, wherever it is named; standard input, too.
mkfifo "$work/pipe"
mkdir "$work/side"
mkfifo "$work/side/pipe" "$work/side/pipe.png"
printf 'mtllib pipe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$work/side/library.obj"
printf 'mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n' >"$work/side/texture.obj"
printf 'newmtl m\nmap_Kd pipe.png\n' >"$work/side/t.mtl"
printf '{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe","byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],%s}' \
    '"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0' \
    >"$work/side/buffer.gltf"
at_once() { expect 1 timeout 20 "$program" "$@" && says err 'is a pipe (allowed: a regular file)'; }
for command in info vis plan bake "walk --offscreen $work/x" "render -o $work/x.png" 'bench collision'; do at_once $command "$work/pipe"; done
at_once info "$work/side/buffer.gltf"
at_once bake $two --probes "$work/pipe"
at_once walk $two --offscreen "$work/x" --replay "$work/pipe"
at_once walk $two --offscreen "$work/x" --light "$work/pipe"
at_once render $two -o "$work/x.png" --light "$work/pipe"
at_once vis $two --against "$work/pipe"
for file in library texture; do
    timeout 20 "$program" info "$work/side/$file.obj" >/dev/null 2>"$work/err"
    [ $? -lt 2 ] || fail "$file.obj hangs"
    says err 'could not be read'
done
expect 1 "$program" info /dev/zero && says err 'is a device'
expect 1 "$program" info - && says err 'standard input is not read'
expect 0 bash -c "cat $two | $program info /dev/stdin; [ \$? -eq 1 ]" && says err 'is a pipe'

# Where nothing can be written, that is said before the work: missing and unwritable folders, folders for files, what is read itself.
cp $two "$work/own.plan"
ln -s own.plan "$work/own"
while read -r said command; do
    expect 1 "$program" ${command//OUT/$work} && says err "${said//_/ }" && sentence
done <<END
No_such_file bake $maps/office.plan -o OUT/no/x.rad
No_such_file render $maps/office.plan -o OUT/no/x.png
No_such_file plan $two -o OUT/no/x.svg
No_such_file walk $two --offscreen OUT/x --stats OUT/no/x.csv
No_such_file walk $two --offscreen OUT/x --video OUT/no/x.mp4
No_such_file bench visibility $two --csv OUT/no/x.csv
Not_a_directory walk $maps/office.plan --bake --offscreen OUT/file/frames
Is_a_directory bake $maps/office.plan -o OUT/side
Is_a_directory vis $two -o OUT/side
is_read,_and_would bake OUT/own.plan -o OUT/own
is_read,_and_would plan OUT/own.plan -o OUT/own
is_read,_and_would vis OUT/own.plan -o OUT/own
is_read,_and_would render OUT/own.plan -o OUT/own
is_read,_and_would vis OUT/own.plan --pairs OUT/1.seen --against OUT/1.seen
is_read,_and_would walk OUT/own.plan --offscreen OUT/x --stats OUT/own.plan
written_twice walk OUT/own.plan --offscreen OUT/x --stats OUT/x.mp4 --video OUT/x.mp4
END
same $two "$work/own.plan" 'the building that was read is overwritten'

# Nor are files written that a model refers to, by their own names or by links: a library and a picture of an .obj, the numbers and a
# picture of a .gltf. Nor is light found beside a building, nor a picture among those of an off-screen walk.
mkdir -p "$work/model" "$work/frames"
printf 'mtllib own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n' >"$work/model/a.obj"
printf 'newmtl m\nmap_Kd own.png\n' >"$work/model/own.mtl"
base64 -d >"$work/model/own.png" <<<'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=='
# Three points, as 36 bytes: the origin, (1, 0, 0) and (0, 0, 1).
printf '%b' "$(printf '\\0%.0s' {1..12})\\0\\0\\0200\\077$(printf '\\0%.0s' {1..8})$(printf '\\0%.0s' {1..8})\\0\\0\\0200\\077" >"$work/model/own.bin"
cat >"$work/model/b.gltf" <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "buffers": [{"uri": "own.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]}],
 "images": [{"uri": "own.png"}], "textures": [{"source": 0}],
 "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]}
END
ln -s ../model/own.mtl "$work/frames/soft"
ln "$work/model/own.bin" "$work/frames/hard"
ln "$work/model/own.png" "$work/frames/hard.glb"
ln "$work/model/own.png" "$work/frames/frame-00003.png"
cp $two "$work/model/c.plan" && cp "$work/1.vis" "$work/model/c.rad"
cp -r "$work/model" "$work/model.kept"
expect 0 "$program" info "$work/model/a.obj"
expect 0 "$program" info "$work/model/b.gltf"
while read -r out command; do
    expect 1 "$program" ${command//MODEL/$work/model} "$work/$out" && sentence
    says err "^enfilade: $work/$out.*: is read, and would be overwritten (allowed: another file)\$"
done <<END
frames/soft bake MODEL/a.obj -o
frames/hard.glb bake MODEL/a.obj -o
frames/soft vis MODEL/a.obj -o
model/own.png vis MODEL/a.obj --pairs
frames/soft plan MODEL/a.obj -o
model/own.png render MODEL/a.obj -o
frames/hard bake MODEL/b.gltf -o
model/own.png render MODEL/b.gltf -o
frames/hard bench visibility MODEL/b.gltf --csv
model/own.bin walk MODEL/b.gltf --offscreen $work/frames --stats
model/own.bin walk MODEL/b.gltf --offscreen $work/frames --video
frames walk MODEL/b.gltf --offscreen
model/c.rad walk MODEL/c.plan --offscreen $work/frames --stats
END
diff -r "$work/model" "$work/model.kept" || fail 'a file that a model refers to is overwritten'

# Daylight: a walk bakes it and keeps it; light under another sky is baked anew, refused where it was given. Where doors stand as they were
# baked, stored light is shown; else it is baked anew.
sed 's/ emission [0-9]*//; /^ *light /d' $two >"$work/unlit.plan"
rm -rf "$work/cache"
window="walk $work/unlit.plan --tour window --size 64x36 --sky 5 --doors drawn"
expect 0 "$program" $window --offscreen "$work/day"
expect 0 "$program" bake "$work/unlit.plan" --sky 5 -o "$work/day.rad"
touch -d '2001-01-01' "$work"/cache/enfilade/*.rad
expect 0 "$program" $window --offscreen "$work/day2" && quiet
same "$work/day/frame-00000.png" "$work/day2/frame-00000.png" 'stored daylight is shown otherwise'
[ -z "$(find "$work"/cache/enfilade/*.rad -newermt 2002-01-01)" ] || fail 'stored daylight is baked again'
expect 0 "$program" ${window/drawn/open} --offscreen "$work/day2" && quiet
cmp -s "$work/day/frame-00000.png" "$work/day2/frame-00000.png" && fail 'light does not follow the doors'
expect 0 "$program" walk "$work/unlit.plan" --tour window --size 64x36 --doors open --offscreen "$work/day2"
says err 'light stays that of the doors as they were baked (--bake'
expect 0 "$program" walk "$work/unlit.plan" --offscreen "$work/day" --tour window --size 64x36 --sky 6 && says err 'passed over.*sky of 5,5,5'
expect 1 "$program" walk "$work/unlit.plan" --offscreen "$work/day" --sky 6 --light "$work/day.rad" && sentence &&
    says err 'day.rad: was made under a sky of 5,5,5 W/m^2/sr (asked for: a sky of 6,6,6 W/m^2/sr)'
expect 0 "$program" render "$work/unlit.plan" --size 32x18 --samples 1 --sky 6 -o "$work/day.png"
rm -rf "$work/cache"
expect 1 "$program" render "$work/unlit.plan" --size 32x18 --samples 1 --fill-lamps off --night -o "$work/day.png" && says err 'nothing emits light: it has no lamps (--fill'
expect 0 "$program" render "$work/unlit.plan" --size 32x18 --samples 1 --fill-lamps off -o "$work/day.png"
# While frames go by the hour may pass, by day; a viewpoint stays, a frame for each ten minutes. Stored light is baked anew for it.
passes="walk $work/unlit.plan --tour window --size 64x36 --doors drawn --time 11:00"
expect 0 "$program" $passes --offscreen "$work/hour"
expect 0 "$program" $passes --until 11:25 --offscreen "$work/hours" && says out '^4 frames'
cmp -s "$work/hours/frame-00000.png" "$work/hours/frame-00003.png" && fail 'the hour does not pass'
same "$work/hour/frame-00000.png" "$work/hours/frame-00000.png" 'a film does not begin at its hour'
expect 1 "$program" $passes --until 23:00 --offscreen "$work/hours" && sentence && says err 'until: it is night at'
expect 1 "$program" ${passes/--time 11:00/--sky 5} --until 12:00 --offscreen "$work/hours" && sentence && says err 'until is for daylight that has hours'
expect 2 "$program" walk $two --until 12:00 && says err 'until is for --offscreen, by day'
expect 2 "$program" walk $two --night --until 12:00 --offscreen "$work/hours" && says err 'until is for --offscreen, by day'
rm -rf "$work/cache"
# A tour can be cut to some rooms, where there are rooms and an automatic tour.
expect 0 "$program" walk $two --offscreen "$work/cut" --size 32x18 --every 1000 --rooms 1 --json && says out '"rooms_entered": 1'
expect 2 "$program" walk $two --rooms 1 && says err '\-\-rooms is for the tour `auto`, off-screen'
expect 1 "$program" walk tests/seeds/room.quads --offscreen "$work/cut" --size 32x18 --rooms 1 && says err 'it has no rooms by which a tour could be cut'
# Night that is asked for is baked, too, where the light that is stored is of a day.
printf 'plan 1\nmaterial m #808080\nmaterial l #ffffff emission 9\nstorey s floor 0 height 3\nroom r 0,0 4,0 4,3 0,3 wall 0.2\n' >"$work/night.plan"
printf 'inlay l ceiling 1,1 2,1 2,2 1,2\nwindow w 4.1,1.5 angle 90 width 1 sill 0.9 height 1\n' >>"$work/night.plan"
walk_night() { expect 0 "$program" walk "$work/night.plan" --offscreen "$work/$1" --step 10 --turn 60 --size 64x36 "${@:2}"; }
walk_night by-day --sky 5
walk_night by-night --night && says err 'passed over.*a sky of 5,5,5'
expect 0 "$program" bake "$work/night.plan" --night -o "$work/night.rad"
walk_night again --light "$work/night.rad" --night
same "$work/by-night/frame-00000.png" "$work/again/frame-00000.png" 'a walk at night shows no light of the lamps'
expect 2 "$program" render $two --night --time 9:00 -o "$work/day.png" && says err '--night is without daylight'
rm -rf "$work/cache"
expect 2 "$program" walk $two --offscreen "$work/day" --verify --sky 5 && says err 'sky is not for --verify'
expect 2 "$program" walk $two --offscreen "$work/day" --verify --day && says err 'daylight is not for --verify'
expect 2 "$program" walk $two --offscreen "$work/day" --verify --look baked && says err 'look baked is not for --verify'
expect 2 "$program" walk $two --offscreen "$work/day" --verify --light x.rad && says err 'light is not for --verify'
# A day with a sun: `--day` alone is the usual one, another hour another day; a home has a day of its own.
expect 0 "$program" bake "$work/unlit.plan" --day -o "$work/usual.rad" && says out 'sky_w  *[1-9]'
expect 0 "$program" bake "$work/unlit.plan" --date 2026-06-21 --time 10:00 --place 50,0 --north 0 --weather clear -o "$work/said.rad"
same "$work/usual.rad" "$work/said.rad" '--day alone is not the usual day'
expect 0 "$program" bake "$work/unlit.plan" --time 11:00+1 -o "$work/zone.rad"
same "$work/usual.rad" "$work/zone.rad" 'a clock an hour ahead shows another day'
expect 1 "$program" bake "$work/unlit.plan" --day --time 11:00 --resume -o "$work/usual.rad" && sentence &&
    says err 'was made under clear sky with the sun [0-9.]* degrees high'
expect 1 "$program" bake "$work/unlit.plan" --date 2026-12-21 --time 03:00 -o "$work/x.rad" && sentence &&
    says err 'the sun is [0-9.]* degrees below the horizon on 2026-12-21 at 03:00'
for command in "bake FILE" "walk FILE --offscreen $work/day" "render FILE -o $work/day.png"; do
    expect 2 "$program" ${command/FILE/"$work/unlit.plan"} --sky 5 --weather overcast && says err '--sky is an even sky without a sun'
done

# What is printed arrives, or the exit status tells: on a full disk, to a closed standard output, which no file takes the place of, and
# to a reader that has gone, by the signal or without it. A file that the shell opened is written into.
expect 1 bash -c "$program info $two >/dev/full" && says err 'standard output: cannot be written: No space left' && sentence
expect 1 bash -c "$program info $two >&-" && says err 'standard output: cannot be written: Bad file' && sentence
expect 1 bash -c "$program --help >/dev/full"
"$program" vis $two -o "$work/closed.vis" <&- >&- 2>&-
"$program" vis $two -o "$work/open.vis" >"$work/out" 2>"$work/err"
same "$work/closed.vis" "$work/open.vis" 'without standard streams a file is another'
expect 0 bash -c "{ sleep 0.3; $program info $two; echo \$? >$work/status; } | true" && quiet
[ "$(cat "$work/status")" -eq 141 ] || fail "a closed pipe ends the program with $(cat "$work/status")"
expect 0 bash -c "trap '' PIPE; { sleep 0.3; $program info $two; echo \$? >$work/status; } | true" && says err 'Broken pipe'
[ "$(cat "$work/status")" -eq 1 ] || fail "a closed pipe, its signal ignored, ends the program with $(cat "$work/status")"
if [ -L /dev/stdout ]; then
    expect 0 bash -c "{ echo head; $program plan $two -o /dev/stdout; echo tail; } >$work/piece.svg"
    [ "$(sed -n '1p;$p' "$work/piece.svg")" = "head
tail" ] && grep -q '</svg>' "$work/piece.svg" || fail 'a redirected /dev/stdout is replaced, not written into'
    [ -L /dev/stdout ] || fail '/dev/stdout is no link any more'
fi
exit $bad
