#!/bin/bash
# check_render.sh - stills as their user meets them: wrong use and bad input said in a sentence, the same bytes on any number of threads,
# nothing left by Ctrl-C, and pictures of the sample buildings as they were.
#   check_render.sh --keep   stores the pictures as the references
. tests/app/checks.sh
draw() { "$program" render "$@" >"$work/out" 2>"$work/err" </dev/null || fail "render $*: $(cat "$work/err")"; }

expect 0 "$program" render --help && says out 'usage: enfilade render'
expect 2 "$program" render && says err 'one building file'
expect 2 "$program" render $maps/two-rooms.plan && says err 'give -o OUT.png'
out=$work/x.png
for wrong in --samples=0 --samples=-3 --samples=x --samples=5000 --size=0x0 --size=99999x10 --size=64 --depth=0 --depth=65 \
    --threads=0 --fov=0 --fov=171 --fov=nan --eye=1,2 --look=x --exposure=9 --exposure=nan --direct=both --tree=oak; do
    expect 2 "$program" render $maps/two-rooms.plan -o "$out" $wrong && says err "render: ${wrong%=*} is"
    [ "$(wc -l <"$work/err")" -eq 2 ] || fail "$wrong: more than a sentence and where help is: $(cat "$work/err")"
done
expect 2 "$program" render $maps/two-rooms.plan -o "$out" --eye 1,1,1 && says err 'needs --look'
expect 2 "$program" render $maps/two-rooms.plan -o "$out" --eye 1,1,1 --look 2,2,1 --view door && says err 'one of them'
expect 1 "$program" render "$work/absent.plan" -o "$out" && says err 'absent.plan'
expect 1 "$program" render $maps/two-rooms.plan -o "$out" --view attic && says err 'no view `attic` (allowed: window, door)'
expect 1 "$program" render $maps/two-rooms.plan -o "$out" --eye 1,1,1 --look 1,1,1 && says err 'allowed: another place'
expect 1 "$program" render $maps/two-rooms.plan -o "$out" --light "$work/absent.rad" && says err 'absent.rad'
printf 'plan 1\nmaterial m #808080\nstorey s floor 0 height 3\nroom r 0,0 4,0 4,3 0,3\n' >"$work/dark.plan"
expect 1 "$program" render "$work/dark.plan" --fill-lamps off --night -o "$out" && says err 'nothing emits light'
[ ! -e "$out" ] || fail 'a picture where there was none to draw'
for name in x.jpg x.PNG.bak; do
    expect 2 "$program" render $maps/two-rooms.plan -o "$work/$name" && says err "$name. (allowed names that end in .png, or have no ending)"
done
# A black picture says why: a room that no light reaches, an eye in a wall of it. The room beside it is lit, and nothing is said.
printf 'material l #ffffff emission 30\nroom lit 5,0 9,0 9,3 5,3 wall 0.1\ninlay l ceiling 6,1 7,1 7,2 6,2\n' >"$work/lit"
cat "$work/dark.plan" "$work/lit" | awk '/^material/ { m = m $0 "\n"; next } /^plan/ { print; next } { r = r $0 "\n" } END { printf "%s%s", m, r }' >"$work/half.plan"
black() { expect 0 "$program" render "$work/half.plan" --fill-lamps off --night --size 32x18 --samples 1 -o "$out" --eye "$1" --look "$2"; }
black 1,1,1.5 2,2,1
says err 'is black: its eye is at (1.00, 1.00, 1.50), and no light reaches what is seen from there (--day'
black 2,-0.05,1.5 2,2,1
says err 'is black: its eye is at (2.00, -0.05, 1.50), and that is in no room'
black 6,1,1.5 8,2,1
quiet

# Quick bakes. One of another building, and one that is damaged, are refused; beside the building they are passed over.
quick="--element 1 --close 0 --reach 0 --refine 0 --residual 0.05 --resolution 50"
for map in two-rooms house office office-plain; do
    "$program" bake $maps/$map.plan $quick -o "$work/$map.rad" >/dev/null 2>&1 || fail "bake of $map"
done
expect 1 "$program" render $maps/two-rooms.plan -o "$out" --light "$work/office.rad"
sentence
cp $maps/two-rooms.plan "$work/two.plan"
head -c 3000 "$work/two-rooms.rad" >"$work/two.rad"
expect 0 "$program" render "$work/two.plan" -o "$out" --size 32x18 --samples 1 --json
says err 'passed over' && says out '"baked": true'
expect 0 "$program" render $maps/two-rooms.plan -o "$out" --size 32x18 --samples 1 --json && says out '"baked": false'
for key in exposure lamps rays ended_matt ended_escaped ended_faint ended_deep seconds; do says out "\"$key\": [0-9]"; done
expect 1 "$program" render $maps/two-rooms.plan -o "$work/no/folder/x.png" --size 32x18 --samples 1
says err 'cannot be written'

# Without a view a still looks where a walk begins: from the start, or where that faces a wall from the first view into a room.
draw $maps/two-rooms.plan --light "$work/two-rooms.rad" -o "$work/start.png" --size 32x18
draw $maps/two-rooms.plan --light "$work/two-rooms.rad" -o "$work/said.png" --size 32x18 --eye 0.8,0.8,1.6 --look 1.566044,1.442788,1.6
python3 tests/app/compare_pictures.py "$work/start.png" "$work/said.png" || fail 'a still does not look where the walk begins'
sed 's/^start .*/start 0.8,0.8 yaw 225/' $maps/two-rooms.plan >"$work/walled.plan"
draw "$work/walled.plan" -o "$work/walled.png" --size 32x18
draw "$work/walled.plan" -o "$work/window.png" --size 32x18 --view window
same "$work/walled.png" "$work/window.png" 'a still looks at a wall where the walk does not'

# Ctrl-C: no file, no half of one.
rm -f "$out"
"$program" render $maps/house.plan --light "$work/house.rad" -o "$out" --samples 4096 >/dev/null 2>"$work/err" &
child=$!
sleep 2
kill -INT $child
wait $child
[ $? -eq 3 ] || fail 'Ctrl-C: exit status'
grep -q 'was not written' "$work/err" || fail "Ctrl-C says $(cat "$work/err")"
[ "$(ls "$work" | grep -c 'x.png')" -eq 0 ] || fail 'Ctrl-C left a file'

# What holds pictures against others sees what an eye sees.
python3 tests/app/compare_pictures.py --check tests/references/hall.png tests/references/lit-house-stairs.png ||
    fail 'pictures are compared wrongly'

# The pictures, on one thread and on seven, by the hierarchy and by the grid.
camera() {
    case $1 in
    two-rooms) echo --view window ;;
    house) echo --view still ;;
    office-plain) echo --eye 0.6,3,1.6 --look 4,0.5,1 ;;
    office) echo --eye 0.6,3,1.6 --look 4,0.5,1 ;;
    esac
}
for map in two-rooms house office office-plain; do
    picture="$maps/$map.plan --light $work/$map.rad --size 208x117 --samples 8 $(camera $map)"
    draw $picture -o "$work/$map.png"
    if [ "${1:-}" = --keep ]; then
        convert "$work/$map.png" -define png:color-type=2 -define png:compression-level=9 -strip tests/references/still-$map.png
    fi
    python3 tests/app/compare_pictures.py "$work/$map.png" tests/references/still-$map.png ||
        fail "$map is not as it was: tests/references/still-$map.png"
done
# Noise is only where something hides a part of a lamp, however many lamps there are: of 66, one sample a pixel says nearly what eight
# say. Edges, which one sample cannot smooth, and shadows are 1 % of this picture; if lamps were taken at random, a
# quarter of it would be off.
draw $maps/office-plain.plan --light "$work/office-plain.rad" --size 208x117 --samples 1 $(camera office-plain) -o "$work/noise.png"
python3 tests/app/compare_pictures.py "$work/noise.png" "$work/office-plain.png" --share 0.03 || fail 'one sample a pixel is noise'
picture="$maps/house.plan --light $work/house.rad --size 64x36 --samples 3 --view still"
draw $picture -o "$work/one.png" --threads 1
draw $picture -o "$work/seven.png" --threads 7
draw $picture -o "$work/grid.png" --tree grid
same "$work/one.png" "$work/seven.png" 'the picture depends on threads'
same "$work/one.png" "$work/grid.png" 'the grid draws another picture'
exit $bad
