#!/bin/bash
# check_ranks.sh - light in parts, by several processes: the same bytes by any number of them. Needs the program of `make mpi=1` and mpirun.
. tests/app/checks.sh

several=build/release-mpi/enfilade
[ -x $several ] && command -v mpirun >/dev/null || { echo "no program made by make mpi=1, or no mpirun"; exit 77; }
ranks() { expect "$1" mpirun --allow-run-as-root --oversubscribe -n "$2" $several bake $maps/two-rooms.plan --night --element 0.4 --residual 0.001 --parts 2 "${@:3}"; }
ranks 0 1 -o "$work/1.rad" --threads 1
for n in 2 4; do
    ranks 0 $n -o "$work/$n.rad" --threads 1 --json && says out "\"ranks\": $n" && says out '"sent_mb": [1-9]'
    same "$work/1.rad" "$work/$n.rad" "$n processes make another light than one"
done
# The same without mpirun, and by the program without MPI.
expect 0 "$program" bake $maps/two-rooms.plan --night --element 0.4 --residual 0.001 --parts 2 -o "$work/none.rad"
same "$work/1.rad" "$work/none.rad" 'mpirun changes the light'
# Light that is stored in parts: the same files.
ranks 0 1 -o "$work/a1.rad" --apart
for n in 2 4; do
    ranks 0 $n -o "$work/a$n.rad" --apart
    for part in "$work"/a1.rad.parts/*; do same "$part" "$work/a$n.rad.parts/${part##*/}" "$n processes store other parts than one"; done
done
# Eight parts, which two and three processes share by how much each sees: not as they are numbered.
build/generate campus-10 1 >"$work/campus-10.plan"
for n in 1 2 3; do
    expect 0 mpirun --allow-run-as-root --oversubscribe -n $n $several bake "$work/campus-10.plan" --night --element 0.6 --residual 0.01 \
        --parts 12 --threads 1 --json -o "$work/c$n.rad" && says out '"parts": 8'
    same "$work/c1.rad" "$work/c$n.rad" "$n processes with eight parts make another light than one"
done
# One process tells what the first of two sends: but for the heads of letters.
expect 0 "$program" bake "$work/campus-10.plan" --night --element 0.6 --residual 0.01 --parts 12 --threads 1 --json -o "$work/c.rad"
told=$(sed -n 's/.*"sent_mb_of_2": \([0-9.]*\).*/\1/p' "$work/out")
expect 0 mpirun --allow-run-as-root --oversubscribe -n 2 $several bake "$work/campus-10.plan" --night --element 0.6 --residual 0.01 \
    --parts 12 --threads 1 --json -o "$work/c.rad"
sent=$(sed -n 's/.*"sent_mb": \([0-9.]*\).*/\1/p' "$work/out")
awk -v t="$told" -v s="$sent" 'BEGIN { exit !(s >= t && s <= 1.02 * t) }' || fail "$sent MB were sent, and $told told beforehand"
# Visibility and truth that processes share: the same bytes, and the same figures.
for n in 1 2 3; do
    for file in "$work/campus-10.plan" $maps/house.plan; do
        expect 0 mpirun --allow-run-as-root --oversubscribe -n $n $several vis "$file" --threads 1 -o "$work/$n.vis"
        [ $n -eq 1 ] && cp "$work/1.vis" "$work/one-$(basename "$file").vis"
        same "$work/one-$(basename "$file").vis" "$work/$n.vis" "$n processes make another visibility of $file than one"
    done
    rm -rf "$XDG_CACHE_HOME"
    expect 0 mpirun --allow-run-as-root --oversubscribe -n $n ${several}-bench light $maps/two-rooms.plan --methods default --points 20 \
        --error 0.05 --csv "$work/light-$n.csv"
    cut -d, -f"$(head -1 "$work/light-$n.csv" | tr , '\n' | grep -n 'gather_\|element_\|vertex_' | cut -d: -f1 | paste -sd,)" \
        "$work/light-$n.csv" >"$work/figures-$n.csv"
    same "$work/figures-1.csv" "$work/figures-$n.csv" "$n processes trace another truth than one"
done
# More processes than parts; a file that is not there: one sentence, and all end.
ranks 1 2 -o "$work/x.rad" --parts 1000 && says err 'give --parts with fewer cells'
expect 1 mpirun --allow-run-as-root --oversubscribe -n 2 $several bake "$work/absent.plan" && says err 'absent.plan'
[ ! -e "$work/x.rad" ] || fail 'a file of light of a bake that was refused'
# One of them is killed at a random moment, again and again (100 times at soak): a sentence, and --resume goes on, in another number of
# processes, to the same bytes. Some kills come before anything is kept: then the bake begins anew.
seed=${ENFILADE_SEED:-$(date +%s)}
RANDOM=$seed
kills=${ENFILADE_SOAK:+100}
left=${kills:-3} told=0
begin=$(date +%s%N)
ranks 0 2 -o "$work/k.rad" --threads 1
taken=$((($(date +%s%N) - begin) / 1000000))
for ((n = 2; left > 0; n = 2 + RANDOM % 3)); do
    kept=$(ls "$work/k.rad.parts" 2>/dev/null | head -1)
    mpirun --allow-run-as-root --oversubscribe -n $n $several bake $maps/two-rooms.plan --night --element 0.4 --residual 0.001 --parts 2 \
        -o "$work/k.rad" --threads 1 --checkpoint 0.001 ${kept:+--resume} >"$work/out" 2>"$work/err" </dev/null &
    run=$!
    # At any moment, or once a first set is whole.
    if [ $((RANDOM % 3)) -eq 0 ]; then
        sleep "$(awk -v r=$RANDOM -v t=$taken 'BEGIN { print r / 32768 * t / 1000 }')"
    else
        for ((i = 0; i < 1000; i++)); do
            [ -n "$(ls "$work"/k.rad.parts/000002-* 2>/dev/null)" ] && break
            sleep 0.02
        done
        sleep 0.$((RANDOM % 10))
    fi
    mapfile -t pids < <(pgrep -P $run)
    [ ${#pids[@]} -gt 0 ] && kill -KILL "${pids[RANDOM % ${#pids[@]}]}" 2>/dev/null
    wait $run && continue
    left=$((left - 1))
    says err 'signal 9\|exit code'  # the latter if it had not begun yet
    grep -q 'enfilade: stopped: what was found is kept' "$work/err" && told=$((told + 1))
    kept=$(ls "$work/k.rad.parts" 2>/dev/null | head -1)
    ranks 0 $((1 + RANDOM % 4)) -o "$work/k.rad" --threads 1 ${kept:+--resume}
    same "$work/1.rad" "$work/k.rad" "seed $seed: a bake of which a process was killed goes on to another light"
    [ ! -e "$work/k.rad.parts" ] || fail "seed $seed: what was kept stays beside the light"
done
echo "$told of ${kills:-3} killed bakes said that their light is kept"
exit $bad
