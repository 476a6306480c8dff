#!/bin/bash
# tsan.sh - what several threads do at once, by the program of `make tsan`, under the thread sanitizer: each report is a failure, and so
# is a wrong exit status. More threads than this machine has cores: the sanitizer follows what waits for what, not who comes first.
. tests/app/checks.sh
grep -q __tsan_init "$program" || die "$program is not built with the thread sanitizer: make tsan"
# Mesa, LLVM and the like are not built with it: what they do among themselves is not looked at. What OpenMP's threads wait for is told
# to the sanitizer by Archer, a part of LLVM's OpenMP.
export OMP_TOOL_LIBRARIES=libarcher.so OMP_NUM_THREADS=3
export TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66 second_deadlock_stack=1 log_path=$work/report"
ran=0
# all_right STATUS COMMAND...: as `expect`, and counts.
all_right() { ran=$((ran + 1)); expect "$@"; }
# interrupted STATUS HUNDREDTHS COMMAND...: likewise, with Ctrl-C after so much CPU, however busy the machine is.
interrupted() {
    local status=$1 hundredths=$2 got
    shift 2
    ran=$((ran + 1))
    "$@" >"$work/out" 2>"$work/err" </dev/null &
    while [ "$(cpu $!)" -lt "$hundredths" ]; do sleep 0.02; done
    kill -INT $! 2>/dev/null
    wait $!
    got=$?
    [ $got -eq "$status" ] || fail "$* exits $got after Ctrl-C, not $status: $(head -2 "$work/err")"
}
coarse="--element 2 --smallest 0.5 --resolution 32"
bake() { all_right 0 "$program" bake "$@" --threads 3; }

# One whose light comes soon.
cat >"$work/closet.plan" <<'END'
plan 1
material white #F2EFE6
material lamp #FFFFFF emission 12
storey ground floor 0 height 2.4
room closet 0,0 1.5,0 1.5,1.5 0,1.5 floor white ceiling white walls white wall 0.15
inlay lamp ceiling 0.5,0.5 1,0.5 1,1 0.5,1
start 0.7,0.7 yaw 40
END

# Visibility: each method, on a building large enough that all threads come to it; with doubts left in the end; stopped; trees. Archer
# says that it is there.
for method in flood plan height flow proof; do
    all_right 0 "$program" vis $maps/rooms-300.plan --pairs-method $method --pairs "$work/$method.seen" --threads 3
done
doom=/usr/share/games/doom/freedoom1.wad
if [ -r $doom ]; then
    all_right 0 "$program" vis $doom --map E1M8 --pairs "$work/x.seen" --threads 3
else
    echo "$script: without $doom: doubts are not settled"
fi
for method in plan proof; do
    all_right 0 "$program" vis $maps/office.plan --pairs-method $method --pairs "$work/x.seen" --threads 3 --seconds 0.05
done
all_right 0 "$program" vis $maps/house.plan -o "$work/x.vis" --threads 3
ARCHER_OPTIONS=verbose=1 all_right 0 "$program" vis $maps/two-rooms.plan --pairs-method plan --pairs "$work/x.seen" --threads 3
says out 'Archer detected OpenMP application with TSan'

# Light: adaptive meshes, rows that go soon, resumed, stopped, daylight, gathered, as a model, at points.
bake $maps/two-rooms.plan -o "$work/a.rad" --row-memory 1 --shots 200
bake $maps/two-rooms.plan -o "$work/a.rad" --row-memory 0 --shots 300 --resume
bake $maps/house.plan -o "$work/lit.rad" $coarse --row-memory 1 --shots 300 -o "$work/lit.glb" --probe 1,1,1,0,0,1
bake "$work/closet.plan" -o "$work/b.rad" --element 0.5 --shots 100 --day
bake "$work/closet.plan" -o "$work/b.rad" --element 0.5 --final-gather
bake $maps/two-rooms.plan -o "$work/b.rad" $coarse --seconds 0.05
bake $maps/two-rooms.plan -o "$work/b.rad" $coarse --shots 20 --method hemicube --no-cull --refine 0
interrupted 0 60 "$program" bake "$work/closet.plan" -o "$work/c.rad" --threads 3
says out 'stopped  *yes'
interrupted 1 250 "$program" bake $maps/house.plan -o "$work/c.rad" $coarse --refine 0 --threads 3 --sky 1
says err 'stopped before all daylight was in'

# Pictures: a still by rays, tours off-screen, lit or not, as a film too.
all_right 0 "$program" render $maps/house.plan --light "$work/lit.rad" --samples 1 --size 48x27 --threads 3 -o "$work/a.png"
all_right 0 "$program" walk $maps/house.plan --offscreen "$work/off" --tour living --size 160x90 --look fine --video "$work/a.mp4"
all_right 0 "$program" walk "$work/closet.plan" --bake --offscreen "$work/off" --size 64x36
all_right 0 "$program" bench light "$work/closet.plan" --methods default --points 5 --error 0.5

# The window: light arrives, the file changes meanwhile, the walk is left in the middle of a bake.
start_screen
python3 tests/app/drive_window.py "$program" $maps/two-rooms.plan "$work" "$work/Xvfb_screen0" tests/references --threads \
    >"$work/log" 2>&1 || { bad=1; sed "s/^/$script: /" "$work/log"; }

reports=$(cat "$work"/report.* 2>/dev/null | grep -c '^WARNING: ThreadSanitizer')
[ "$reports" -eq 0 ] || { bad=1; cat "$work"/report.*; }
echo "$script: $ran commands and two walks in the window, $reports reports"
exit $bad
