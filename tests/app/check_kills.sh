#!/bin/bash
# check_kills.sh - every writer of a file, killed at random moments, on a disk that fills up at a random byte, and on one that is full:
# the file is then the earlier one or the new one, whole, byte for byte, and the next run leaves nothing beside it. `make soak` kills each
# 200 times, `make test` a few. Killed at chosen system calls, 1,000 times at soak, they are in test_kills.c.
. tests/app/checks.sh
times=${ENFILADE_SOAK:+200}
times=${times:-2}
seed=${ENFILADE_SEED:-$(date +%s)}
RANDOM=$seed
script="$script, seed $seed"
now() { date +%s%N; }

# check NAME FILE: `enfilade` with the arguments in `earlier` makes an earlier FILE, with those in `later` the new one.
check() {
    local name=$1 file=$2 begun taken wait size
    rm -f "$file"
    "$program" "${earlier[@]}" >/dev/null 2>"$work/err" || die "$name: $(cat "$work/err")"
    cp "$file" "$work/earlier"
    begun=$(now)
    "$program" "${later[@]}" >/dev/null 2>&1 || die "$name: cannot write again"
    taken=$(($(now) - begun))
    cp "$file" "$work/later"
    cmp -s "$work/earlier" "$work/later" && die "$name: both are the same: nothing would show"
    size=$(stat -c %s "$work/later")
    for ((i = 0; i < times; i++)); do
        cp "$work/earlier" "$file"
        # From before it begins to after it ends.
        wait=$((RANDOM * 32768 + RANDOM))
        wait=$((wait % (taken * 11 / 10)))
        "$program" "${later[@]}" >/dev/null 2>&1 &
        sleep "$(printf '0.%09d' $((wait % 1000000000)))"
        [ $wait -ge 1000000000 ] && sleep $((wait / 1000000000))
        kill -KILL $! 2>/dev/null
        wait $! 2>/dev/null
        cmp -s "$file" "$work/earlier" || cmp -s "$file" "$work/later" || die "$name: killed after $wait ns: a broken file"
    done
    "$program" "${later[@]}" >/dev/null 2>&1
    cmp -s "$file" "$work/later" || die "$name: cannot write after kills"
    [ -z "$(find "$(dirname "$file")" -name "$(basename "$file").*")" ] || die "$name: a kill left a part of a file"
    for ((i = 0; i < times; i++)); do
        cp "$work/earlier" "$file"
        # One at least, which the sentence that tells of it needs: the limit is of every file.
        blocks=$((1 + RANDOM % ((size - 1) / 1024)))
        full_disk $blocks "$program" "${later[@]}"
        [ $? -eq 1 ] || die "$name: a disk full after $blocks kB went unseen"
        [ -s "$work/err" ] || die "$name: a full disk is not told of"
        cmp -s "$file" "$work/earlier" || die "$name: a disk full after $blocks kB cost the earlier file"
        [ -z "$(find "$(dirname "$file")" -name "$(basename "$file").*")" ] || die "$name: a full disk left a part of a file"
    done
    [ -n "$full" ] || return 0
    cp "$work/earlier" "$work/disk.earlier"
    unshare -rm bash -c 'mount -t tmpfs -o size=$(($(stat -c %s "$1") / 4096 * 4 + 8))k none "$2" && cp "$1" "$3" &&
        { shift 3; "$@" >/dev/null 2>"$WORK/err"; [ $? -eq 1 ]; } && cmp -s "$WORK/earlier" "$FILE"' \
        disk "$work/earlier" "$(dirname "$file")" "$file" "$program" "${later[@]}" || die "$name: a full disk cost the earlier file"
}

export WORK=$work FILE
# Without leave to mount, disks are full by limit alone.
full=$(unshare -rm mount -t tmpfs none "$work" 2>/dev/null && echo yes)
mkdir "$work/out"
plan=build/maps/two-rooms.plan

FILE=$work/out/a.vis
earlier=(vis $plan -o "$FILE" --square 2)
later=(vis build/maps/house.plan -o "$FILE")
check trees "$FILE"
FILE=$work/out/a.seen
earlier=(vis $plan --pairs "$FILE")
later=(vis build/maps/office.plan --pairs "$FILE")
check pairs "$FILE"
FILE=$work/out/a.rad
earlier=(bake $plan -o "$FILE" --shots 10)
later=(bake $plan -o "$FILE" --shots 300)
check light "$FILE"
FILE=$work/out/a.glb
earlier=(bake $plan -o "$FILE" --shots 10 --element 1)
later=(bake $plan -o "$FILE" --shots 300)
check model "$FILE"
FILE=$work/out/a.svg
earlier=(plan $plan -o "$FILE")
later=(plan build/maps/house.plan -o "$FILE" --from 1,1,1.5)
check drawing "$FILE"
mkdir "$work/out/frames"
FILE=$work/out/frames/frame-00000.png
earlier=(walk $plan --offscreen "$work/out/frames" --tour window --size 64x36)
later=(walk build/maps/house.plan --offscreen "$work/out/frames" --tour living --size 160x90)
check frame "$FILE"
exit 0
