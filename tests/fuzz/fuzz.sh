#!/bin/bash
# fuzz.sh SECONDS [TARGET...] - runs fuzz targets one after the other, each for so many seconds without sanitizers and a
# quarter of that with them, over a corpus that both let grow in build/fuzz/corpus. What came of it is added up in
# build/fuzz/tally over all runs. Inputs that crash, take too long or too much memory are left in build/fuzz; 1 if there are any.
seconds=${1:?usage: tests/fuzz/fuzz.sh SECONDS [TARGET...]}
shift
targets=${*:-$(cd tests/fuzz && ls fuzz_*.c | sed 's/fuzz_\(.*\)\.c/\1/')}
# Entropy, by which libFuzzer weighs inputs, costs a quarter of the time here.
limits=(-rss_limit_mb=2048 -timeout=20 -entropic=0)

# The seeds of a target, with commas between.
seeds() {
    case $1 in
    plan) ls tests/seeds/*.plan maps/buildings/two-rooms.plan ;;
    sh3d) ls tests/seeds/home* tests/seeds/*.sh3d* ;;
    soup_obj) ls tests/seeds/*.obj ;;
    gltf) ls tests/seeds/*.gl* ;;
    foreign) ls tests/seeds/*.dae tests/seeds/*.3ds ;;
    recording) ls tests/seeds/*.path ;;
    quake) ls tests/seeds/*.bsp ;;
    ifc*) ls tests/seeds/*.ifc ;;
    photometry) ls tests/seeds/*.ies tests/seeds/*.ldt ;;
    pipeline) ls tests/seeds/s*.plan tests/seeds/room* tests/seeds/*.{prt,files} ;;
    *) ls tests/seeds/*."$1" 2>/dev/null ;;
    esac | sort -u | paste -sd,
}
# Longer inputs take longer and find no more.
longest() {
    case $1 in
    seen | prt | quads | recording) echo 600 ;;
    pipeline | quake) echo 8000 ;;
    sh3d) echo 4000 ;;
    *) echo 3000 ;;
    esac
}
# run BUILD TARGET SECONDS
run() {
    local log=build/fuzz/$2-$1.log seeds
    seeds=$(seeds "$2")
    mkdir -p "build/fuzz/corpus/$2" build/fuzz/tally
    ENFILADE_TALLY=build/fuzz/tally/$2-$1 "build/$1/tests/fuzz_$2" "${limits[@]}" -max_len="$(longest "$2")" \
        -max_total_time="$3" -artifact_prefix="build/fuzz/found-$2-" ${seeds:+-seed_inputs=$seeds} \
        "build/fuzz/corpus/$2" >"$log" 2>&1 && return
    echo "$2, $1: $(grep -aE 'ERROR|SUMMARY|Test unit written' "$log" | head -3)"
    bad=1
}
# One line: what was counted by a target in a build.
tell() {
    [ -e "build/fuzz/tally/$1-$2" ] || return
    read -r tried passed cells walked shot cpu < <(od -An -t u8 -w48 "build/fuzz/tally/$1-$2")
    printf '%-10s %-6s %12d %10d %9d %9d %9d %8d %9d\n' "$1" "$2" "$tried" "$passed" "$cells" "$walked" "$shot" \
        $((cpu / 1000000)) $((tried * 1000 / (cpu / 1000 + 1)))
}
bad=0
for target in $targets; do
    run swift "$target" "$seconds"
    run fuzz "$target" $(((seconds + 3) / 4))
done
printf '%-10s %-6s %12s %10s %9s %9s %9s %8s %9s\n' target build executions passed cells walked shot cpu-s 'a cpu-s'
for target in $(cd tests/fuzz && ls fuzz_*.c | sed 's/fuzz_\(.*\)\.c/\1/'); do
    tell "$target" swift
    tell "$target" fuzz
done
exit $bad
