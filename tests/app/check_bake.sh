#!/bin/bash
# check_bake.sh - light from file to file: the same bytes however it is made, what is refused and what is said of it, and earlier files
# kept whatever happens.
. tests/app/checks.sh

# Light: the promised keys, the same bytes on any number of threads, with whatever memory, culled or not; the help's methods.
bake() { expect "$1" "$program" bake $maps/two-rooms.plan --element 0.5 --resolution 50 --residual 0.05 "${@:2}"; }
bake 0 -o "$work/1.rad" --threads 1 --json --probe 1,1,0,0,0,1
for key in polygons patches elements shots residual_share emitted_w absorbed_w escaped_w unshot_w sky_w elements_drawn_mean polygons_drawn_mean seconds seconds_visibility peak_mb
do says out "\"$key\": [0-9]"; done
says out '"probes": \['
# All power is in watts, and none is lost; tolerance: rounding of the nine digits that are printed.
watts() { sed -n "s/.*\"$1_w\": \([-0-9.e]*\).*/\1/p" "$work/out"; }
awk "BEGIN { lost = $(watts emitted) - $(watts absorbed) - $(watts escaped) - $(watts unshot)
             exit !($(watts unshot) > 0 && lost * lost < 1e-14 * $(watts emitted) ^ 2) }" || fail "power is lost: $(grep _w "$work/out")"
# Rounding makes no share of light negative: of this one it took a 10^16th part too much.
printf 'quad a 0 .3 0 0 0 1 0 0 1 1 0 0 1 0\nquad b 0 .31 0 0 1 0 1 1 1 1 1 1 0 1\nquad c 0 .37 3 0 0 4 0 0 4 1 0 3 1 0\n' >"$work/black.quads"
expect 0 "$program" bake "$work/black.quads" -o "$work/x.rad" --json && says out '"residual_share": 0.0,'
# A file whose ending says something else is no .rad file.
bake 2 -o "$work/x.obj" && says err 'x.obj. (allowed names that end in .rad or .glb, or have no ending'
[ ! -e "$work/x.obj" ] || fail 'an .obj file of light'
bake 0 -o "$work/light" && same "$work/light" "$work/1.rad" 'a name without an ending makes another .rad file'
bake 0 -o "$work/2.rad" --threads 2 --row-memory 0
bake 0 -o "$work/7.rad" --threads 7 --row-memory 1
bake 0 -o "$work/none.rad" --no-cull
for rad in 2 7 none; do cmp -s "$work/1.rad" "$work/$rad.rad" || fail ".rad differs: $rad"; done
printf '# a point\n1 1 0 0 0 1\n' >"$work/points"
bake 0 -o "$work/1.rad" --probes "$work/points" --probe 1,1,1,0,0,-1
[ "$(awk 'NF == 12 && $7 > 0' "$work/out" | wc -l)" -eq 2 ] || fail "two probes are $(tail -2 "$work/out")"
tail -2 "$work/out" >"$work/probes"
bake 0 -o "$work/1.rad" --probes "$work/points" --probe 1,1,1,0,0,-1 --threads 1
tail -2 "$work/out" | cmp -s - "$work/probes" || fail "probes on one thread are $(tail -2 "$work/out")"
printf '1 1 0 0 1\n' >"$work/points"
bake 1 -o "$work/1.rad" --probes "$work/points" && says err 'points:1'
# Broken off and resumed, it ends the same; what does not fit is refused.
bake 0 -o "$work/part.rad" --shots 100 && says out 'shots  *100'
bake 0 -o "$work/part.rad" --resume
same "$work/1.rad" "$work/part.rad" 'a resumed bake ends otherwise'
bake 1 -o "$work/part.rad" --resume --per-patch 1 && says err 'asked for: 0.5 m, 1'
bake 1 -o "$work/part.rad" --resume --doors open && says err 'was made with door'
bake 1 -o "$work/part.rad" --resume --doors between=40% && says err 'was made with door'
bake 1 -o "$work/part.rad" --doors cellar=open && says err 'no door is called `cellar` (allowed: all, between, front)'
bake 1 -o "$work/part.rad" --doors 'between=wide' && says err '`wide` is no state of a door'
bake 1 -o "$work/part.rad" --resume --sky 5 && says err 'was made under no daylight'
bake 0 -o "$work/gathered.rad" --final-gather --threads 1 --json && says out '"nodes": [1-9]'
bake 0 -o "$work/gathered.2.rad" --final-gather --threads 2
same "$work/gathered.rad" "$work/gathered.2.rad" 'the final gather depends on threads'
expect 0 "$program" walk $maps/two-rooms.plan --light "$work/gathered.rad" --offscreen "$work/gathered" --size 64x48 --every 1000 --doors drawn
bake 0 -o "$work/gathered.rad" --resume
same "$work/gathered.rad" "$work/1.rad" 'a resumed bake keeps what was gathered before'
# In parts: the promised keys, the same bytes on any number of threads, and what does not go with parts.
bake 0 -o "$work/parts.rad" --parts 2 --threads 1 --json
for key in parts ranks elements_made_share sent_mb; do says out "\"$key\": [0-9]"; done
bake 0 -o "$work/parts.2.rad" --parts 2 --threads 2
same "$work/parts.rad" "$work/parts.2.rad" 'light in parts depends on threads'
bake 0 -o "$work/part.rad" --parts 4194304
same "$work/part.rad" "$work/1.rad" 'one part is another light than the whole'
expect 0 "$program" walk $maps/two-rooms.plan --light "$work/parts.rad" --offscreen "$work/in-parts" --size 64x48 --every 1000 --doors drawn
# Killed, it goes on from what it has kept beside the file; what was kept is gone once the light is whole.
bake 1 -o "$work/kept.rad" --parts 2 --resume && says err 'kept.rad.parts: holds no light' && sentence
bake 2 -o "$work/kept.rad" --checkpoint 1 && says err 'give --parts'
bake 0 -o "$work/never.rad" --parts 2 --residual 0.002
"$program" bake $maps/two-rooms.plan --element 0.5 --resolution 50 --residual 0.002 -o "$work/kept.rad" --parts 2 --checkpoint 0.001 \
    >/dev/null 2>&1 &
for ((i = 0; i < 600; i++)); do
    [ -n "$(ls "$work"/kept.rad.parts/000002-* 2>/dev/null)" ] && break
    sleep 0.02
done
kill -KILL $! 2>/dev/null && wait $! 2>/dev/null
[ -e "$work/kept.rad.parts" ] && bake 0 -o "$work/kept.rad" --parts 2 --residual 0.002 --resume --json && says out '"checkpoints": 0'
[ ! -e "$work/kept.rad.parts" ] || fail 'what was kept stays beside the light'
same "$work/kept.rad" "$work/never.rad" 'a killed bake that goes on makes another light'
bake 2 -o "$work/parts.rad" --parts 0 && says err 'parts'
# Stored in parts: the same files on any number of threads; walks and pictures show them; a small budget makes it so by itself; what
# needs the whole is refused.
bake 0 -o "$work/apart.rad" --apart --parts 2 --threads 1 --json && says out '"elements": [1-9]'
bake 0 -o "$work/apart.2.rad" --apart --parts 2 --threads 2
for part in "$work"/apart.rad.parts/*; do
    same "$part" "$work/apart.2.rad.parts/${part##*/}" 'light that is stored in parts depends on threads'
done
expect 0 "$program" walk $maps/two-rooms.plan --light "$work/apart.rad" --offscreen "$work/apart" --size 64x48 --every 100 --doors drawn
expect 0 "$program" render $maps/two-rooms.plan --light "$work/apart.rad" --size 64x48 --samples 1 -o "$work/apart.png"
expect 1 "$program" render $maps/two-rooms.plan --light "$work/apart.rad" --eye 500,500,500 --look 0,0,0 --size 64x48 -o "$work/apart.png" && says err 'no light about the eye'
bake 1 -o "$work/apart.rad" --apart --parts 2 --resume && says err 'its light is whole' && sentence
bake 2 -o "$work/apart.rad" --apart -o "$work/apart.glb" && says err 'no OUT.glb'
bake 2 -o "$work/apart.rad" --apart --seconds 5 && says err 'parts has no'
expect 1 "$program" bake $maps/house.plan --memory 80 -o "$work/over.rad" && sentence && says err 'baking takes more than 80 MB'
[ ! -e "$work/over.rad.parts" ] || fail 'a bake that was refused leaves a folder'
rm "$work"/apart.rad.parts/*
expect 1 "$program" walk $maps/two-rooms.plan --light "$work/apart.rad" --offscreen "$work/apart" --size 64x48 --every 100 && says err '0-of-' && sentence
# Of a program without MPI mpirun may start one process, not several.
OMPI_COMM_WORLD_SIZE=2 bake 2 -o "$work/of-two.rad" && says err 'make mpi=1'
[ ! -e "$work/of-two.rad" ] || fail "a file of light by one of several processes"
# A model beside the light or instead of it; whole or not at all.
bake 0 -o "$work/both.rad" -o "$work/both.GLB" && says out 'model  *.*both.GLB'
same "$work/both.rad" "$work/1.rad" 'a model changes the light'
bake 0 -o "$work/one.glb" --threads 3 && cmp -s "$work/one.glb" "$work/both.GLB" || fail 'models differ'
[ -z "$(ls "$work"/cache/enfilade/*.rad 2>/dev/null)" ] || fail 'a model asked for alone leaves light in the cache'
expect 0 "$program" info "$work/one.glb" && says out 'polygons'
bake 1 -o "$work/no/such/folder/x.glb" && says err 'cannot be written'
full_disk 8 "$program" bake $maps/two-rooms.plan -o "$work/one.glb"
[ $? -eq 1 ] || fail 'a full disk went unseen by a model'
same "$work/one.glb" "$work/both.GLB" 'an earlier .glb file was lost'
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
# Lamps for dark rooms: told, part of the light that is found again, and refused where they are switched off.
printf 'plan 1\nmaterial m #808080\nstorey s floor 0 height 3\nroom r 0,0 4,0 4,3 0,3\n' >"$work/dark.plan"
expect 0 "$program" bake "$work/dark.plan" --element 0.5 -o "$work/dark.rad" && says err '1 plain lamp was added in 1 room without light'
expect 0 "$program" render "$work/dark.plan" --size 32x18 --samples 1 --direct baked -o "$work/dark.png" && says out 'light read'
expect 1 "$program" render "$work/dark.plan" --light "$work/dark.rad" --fill-lamps off --size 32x18 --samples 1 --direct baked -o "$work/dark.png" &&
    says err 'was made with 1 fill lamps (asked for: 0; --fill-lamps on or off)'
expect 1 "$program" bake "$work/dark.plan" --fill-lamps off -o "$work/off.rad" && says err 'nothing emits light'
# Lamps by number, name and room; light of one state is no light of another, unless it holds each lamp.
lamps=maps/buildings/studio.plan
expect 0 "$program" info "$lamps" --lamps && says out '1  bulb  *studio' && says out '2  bulb  *bath'
expect 0 "$program" info "$lamps" --lamps --json && says out '"room": "bath"'
still() { expect "$1" "$program" render "$lamps" --night --light "$work/$2.rad" --lamps "$3" --size 64x36 --samples 1 --direct baked --eye 3,1,1.6 --look 3,3,1 -o "$work/still.png"; }
expect 0 "$program" bake "$lamps" --lamps 'off,bath=on' --element 0.5 -o "$work/one.rad" --json && says out '"emitted_w": 61.' && says out '"lamps": 2' && says out '"lamps_known": 0'
still 0 one '1=off'
still 1 one on && says err 'was made with lamp 1, bulb, off (asked for: on; `bake --lamps each` makes light of all states)'
expect 0 "$program" bake "$lamps" --lamps each --element 0.5 -o "$work/each.rad" --json && says out '"lamps_known": 2' && says out '"emitted_w": 122.'
for state in on off 'studio=40%#ff8000' '1=off'; do still 0 each "$state"; done
still 1 each 'kitchen=off' && says err 'no lamp and no room is called `kitchen` (allowed: 1 to 2, all, a room, or a lamp: bulb, bulb)'
still 1 each '1=dim' && says err '`dim` is no state of a lamp'
expect 1 "$program" bake "$lamps" --lamps off -o "$work/off.rad" && says err 'nothing emits light'
expect 2 "$program" bake "$lamps" --lamps each --final-gather -o "$work/x.rad" && says err 'is not gathered by --final-gather'
expect 0 "$program" bake "$lamps" --lamps each --element 0.5 --shots 20 -o "$work/x.rad" && says err 'the light of each lamp is not known: light was not shot and shown to the end'
# No light, an open building, an element for each grain of sand.
printf 'quad a .5 0 0 0 0 1 0 0 1 1 0 0 1 0\n' >"$work/dark.quads"
expect 1 "$program" bake "$work/dark.quads" -o "$work/x.rad" && says err 'nothing emits light'
printf 'quad a .5 1 0 0 0 1 0 0 1 1 0 0 1 0\n' >"$work/open.quads"
expect 0 "$program" bake "$work/open.quads" -o "$work/x.rad" && says err 'is open: 100 % of its light escaped'
expect 0 "$program" bake "$work/dark.quads" --sky 5 -o "$work/x.rad" && says out 'sky_w  *[1-9]'
printf 'PRT1\n2\n1\n4 0 1 (0 0 9) (0 0 0) (0 9 0) (0 9 9)\n' >"$work/two.prt"
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
bad_quad 0 'reflect more than 0.99 and were capped, `a` first; the most was 1' "quad a 1 0 $floor"
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
bake 1 -o "$work/cache" && says err 'Is a directory'
bake 1 -o /dev/full && says err 'No space left'
[ -c /dev/full ] || fail 'a device was replaced by a file'
full_disk 1 "$program" bake $maps/two-rooms.plan -o "$work/1.rad"
[ $? -eq 1 ] || fail 'a full disk went unseen'
says err 'cannot be written'
same "$work/1.rad" "$work/2.rad" 'an earlier .rad file was lost'
if unshare -rm true 2>/dev/null; then
    # Room for trees, and for a light of the least size, but not for this one: it is asked for when the mesh is there.
    small_disk() { # a command, whose cache, and $work/disk, hold 1.2 MB
        mkdir -p "$work/disk"
        expect "$1" unshare -rm bash -c 'mount -t tmpfs -o size=1200k none "$1" && shift && exec "$@"' disk "$work/disk" \
            env XDG_CACHE_HOME="$work/disk" "$program" bake $maps/two-rooms.plan --element 0.1 --per-patch 8 --refine 0 --close 0 --reach 0 \
            --shots 1 "${@:2}"
    }
    small_disk 0 && says err 'No space left on device: visibility and light are not kept (bake -o' && says out 'shots  *1$'
    grep -q '^file' "$work/out" && fail 'light is said to be where it is not'
    small_disk 1 -o "$work/disk/x.rad" && says err 'x.rad: cannot be written: No space left'
fi
for wait in 0.01 0.02 0.03 0.05 0.08 0.12 0.2; do
    "$program" bake $maps/two-rooms.plan -o "$work/1.rad" --element 0.5 --resolution 50 --residual 0.05 >/dev/null 2>&1 &
    sleep $wait
    kill -KILL $! 2>/dev/null
    wait $! 2>/dev/null
    same "$work/1.rad" "$work/2.rad" "killed after $wait s, it left a broken file"
done
rm -f "$work"/1.rad.??????
# Interrupted, it stores what there is.
"$program" bake $maps/office-plain.plan -o "$work/early.rad" --json >"$work/out" 2>"$work/err" &
# It takes note of Ctrl-C once there is light: then the signal, 2, is among those that it catches.
started $!
while grep -q 'SigCgt:.*[014589cd]$' /proc/$!/status; do sleep 0.1; done 2>/dev/null
kill -INT $!
wait $!
[ $? -eq 3 ] || fail 'an interrupted bake has not its own status'
says out '"stopped": true' && says err 'stopped: this is the light of [0-9]* shots, from which --resume goes on'
expect 0 "$program" bake $maps/office-plain.plan -o "$work/early.rad" --resume --seconds 0.01 && says out 'stopped  *no'
# A limit of time is one of the whole bake: here elements that follow the light and shadows take longer, and are left out. Measured in CPU,
# since other programs take their part of the clock: half a second of two threads, and what is not cut short; without limit it takes 15. A
# fast machine is done with these elements in two seconds. Daylight is whole or not at all.
TIMEFORMAT=%0U
seconds=$({ time expect 0 "$program" bake $maps/house.plan -o "$work/brief.rad" --seconds 0.5 --threads 2 --json; } 2>&1)
says err '0.5 s are too few for elements that follow the light' && says err 'after 0.5 s the light straight from lamps was not found anew'
says out '"stopped": false'
[ "$seconds" -lt 6 ] 2>/dev/null || fail "a bake of half a second took, of CPU: $seconds"
expect 0 "$program" render $maps/house.plan --light "$work/brief.rad" --view still --size 32x18 --samples 1 --direct baked -o "$work/brief.png"
expect 1 "$program" bake $maps/house.plan --day -o "$work/none.rad" --seconds 0.01 && says err 'all daylight was not in after 0.01 s: nothing is stored'
# At any moment: what there is goes on to the same end; before there is any, Ctrl-C ends it as any program, and leaves nothing.
RANDOM=${ENFILADE_SEED:-$(date +%s)}
for ((i = 0; i < ${ENFILADE_SOAK:+14}+6; i++)); do
    rm -f "$work/early.rad"
    wait=$((RANDOM % 16))  # of about 15
    "$program" bake $maps/two-rooms.plan -o "$work/early.rad" --element 0.5 --resolution 50 --residual 0.05 >/dev/null 2>"$work/err" &
    started $!
    while [ "$(cpu $!)" -lt $wait ]; do sleep 0.01; done
    kill -INT $! 2>/dev/null
    wait $!
    case $? in
    0 | 3) bake 0 -o "$work/early.rad" --resume && same "$work/early.rad" "$work/2.rad" "interrupted after $wait hundredths, it ends otherwise" ;;
    130) [ ! -e "$work/early.rad" ] || fail "interrupted after $wait hundredths, before there was light, it leaves a file" ;;
    *) fail "interrupted after $wait hundredths it ends with $?: $(head -2 "$work/err")" ;;
    esac
done
# Lamps of a home give light.
expect 0 "$program" bake $maps/house.sh3d -o "$work/x.rad" --element 1 --resolution 50 --residual 0.2
expect 0 "$program" bake $maps/two-rooms.plan --element 1
cached=$(ls "$work"/cache/enfilade/*.rad) || fail 'no light in the cache'
# It is shown from there as if it were given, if it is whole; a file beside the building that does not fit is told of, too.
cp $maps/two-rooms.plan "$work/lit.plan"
show() { expect 0 "$program" walk "$work/lit.plan" --offscreen "$work/$1" --size 64x64 --fps 1 --doors drawn "${@:2}"; }
show given --light "$cached" && quiet
show found && quiet
same "$work/given/frame-00000.png" "$work/found/frame-00000.png" 'the light in the cache is not shown'
cp "$work/short.rad" "$work/lit.rad"
show beside && says err 'passed over: .*/lit.rad: has 3000 bytes'
same "$work/given/frame-00000.png" "$work/beside/frame-00000.png" 'the light in the cache is not shown instead'
cp "$work/short.rad" "$cached" && rm "$work/lit.rad"
show dark && says err "passed over: $cached: has 3000 bytes"
cmp -s "$work/given/frame-00000.png" "$work/dark/frame-00000.png" && fail 'damaged light is shown'
# Photometric files: by option, beside a home by the lamp's name; told by info; light of their own, the same on any number of threads.
seeds=tests/seeds
expect 0 "$program" info $maps/two-rooms.plan --photometry lamp=$seeds/panel.ldt
says out 'photometry tests/seeds/panel.ldt: 1 light, 25[0-9]* lm, 0 % of it upwards; 4 angles in 8 planes; opening 0.6 x 0.6 m'
bake 0 -o "$work/panel.rad" --photometry lamp=$seeds/panel.ldt --threads 1
bake 0 -o "$work/panel.2.rad" --photometry lamp=$seeds/panel.ldt --threads 2 --no-cull
same "$work/panel.rad" "$work/panel.2.rad" 'the light of a photometric file depends on threads or culling'
cmp -s "$work/panel.rad" "$work/1.rad" && fail 'a photometric file changes nothing'
bake 1 -o "$work/x.rad" --photometry nobody=$seeds/panel.ldt && sentence && says err 'no lamp of build/maps/two-rooms.plan is called `nobody`'
bake 1 -o "$work/x.rad" --photometry lamp=$seeds/room.obj && sentence && says err 'room.obj:2: the type of luminaire is'
bake 1 -o "$work/x.rad" --photometry lamp && sentence && says err 'allowed NAME=FILE'
# Light made with the file fits with it alone.
expect 1 "$program" walk $maps/two-rooms.plan --light "$work/panel.rad" --offscreen "$work/lit"
expect 0 "$program" render $maps/two-rooms.plan --light "$work/panel.rad" --photometry lamp=$seeds/panel.ldt -o "$work/x.png" --size 32x24 --samples 1
cp maps/buildings/house.sh3d "$work/home.sh3d" && cp $seeds/spot.ies "$work/pendant.ies" && cp $seeds/room.obj "$work/table-lamp.ldt"
expect 0 "$program" info "$work/home.sh3d" && says out 'pendant.ies: 3 lights' && says err 'passed over: .*table-lamp.ldt:2:'

# Light as planners ask for it: the same table on any number of threads, a line a room; its plan; the keys of its JSON.
plan() { expect 0 "$program" light $maps/two-rooms.plan --sky none "$@"; }
plan --threads 1 --svg "$work/light.svg" && cp "$work/out" "$work/light.csv"
says out '^storey,room,area_m2,plane_m,points,' && says out '^ground,parlour,16.97,0.850,40,0,[0-9.]*,[0-9.]*,[0-9.]*,0.[0-9]*,0.[0-9]*,,,,,,$'
[ "$(wc -l <"$work/out")" -eq 3 ] || fail "two rooms have $(cat "$work/out")"
plan --threads 2 && same "$work/out" "$work/light.csv" 'the table of rooms depends on threads'
grep -q '>study: [0-9]* lx<' "$work/light.svg" && grep -q '>300<' "$work/light.svg" || fail 'a plan without a room or a line'
plan --json && says out '"uniformity": 0' && says out '"from_rooms_share": 0' && says out '"seconds_rooms": [0-9]'
expect 1 "$program" light $maps/two-rooms.plan --sky none --storey 5 --svg "$work/light.svg" && says err 'has no storey 5 (allowed 0 to 0)'
exit $bad
