#!/bin/bash
# coverage.sh BUILD FOLDER SUITES [CORPUS] - which share of the lines of each file of a folder is run by the unit tests that match a
# pattern ('' for none) and by the fuzz targets on the seeds; with CORPUS, on what that folder holds for each target as well. Of maps
# the sums by reader follow. BUILD is one of config=coverage.
build=${1:?usage: tests/coverage.sh BUILD FOLDER SUITES [CORPUS]}
folder=${2:-maps}
corpus=$4
find "$build" -name '*.gcda' -delete
[ -z "$3" ] || ENFILADE_BUILD=$build "$build/tests/all" -j"$(nproc)" --filter "$3" >"$build/tests/all.log" 2>&1 ||
    echo "not all tests pass: $build/tests/all.log"
for target in tests/fuzz/fuzz_*.c; do
    name=$(basename "$target" .c)
    mapfile -t inputs < <(find tests/seeds ${corpus:+"$corpus/${name#fuzz_}"} -type f 2>/dev/null)
    "$build/tests/try_$name" 0 1 "${inputs[@]}" >"$build/tests/$name.log" 2>&1 || echo "fails: $build/tests/$name.log"
done
# `File 'maps/x.c'`, then `Lines executed:98.00% of 50`; a file may be told of with each that includes it.
find "$build/$folder" -name '*.gcno' | while read -r object; do
    gcov -n "$object" 2>/dev/null | awk -v folder="$folder/" '
        /^File/ { name = substr($2, 2, length($2) - 2) }
        /^Lines/ && index(name, folder) == 1 && name ~ /\.c$/ { split($0, p, /[:%]| of /); print name, p[2], p[4] }'
done | sort -u | awk '
    function tell(name, run, lines) { printf "%-32s %6.2f %% of %5d\n", name, 100 * run / (lines ? lines : 1), lines }
    function group(name) {
        if (name ~ /maps\/(plan|curved)\//) return "plan"
        if (name ~ /maps\/enclose\//) return "plan and sh3d: enclosing"
        if (name ~ /maps\/sweethome\/|building\/(zip|texture)/) return "sh3d"
        if (name ~ /maps\/doom\//) return "wad"
        if (name ~ /polygons\/gltf/) return "gltf"
        if (name ~ /polygons\/(soup|obj)/) return "obj and soups"
        if (name ~ /quake\/prt|building\/scan/) return "prt"
        if (name ~ /polygons\/quads/) return "quads"
        return "all others"
    }
    { run = $2 * $3 / 100; tell($1, run, $3); lines += $3; ran += run
      by_lines[group($1)] += $3; by_run[group($1)] += run }
    END { if (lines && "gltf" in by_lines) for (g in by_lines) tell("  " g, by_run[g], by_lines[g]); tell("all", ran, lines) }'
