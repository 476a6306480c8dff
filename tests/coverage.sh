#!/bin/bash
# coverage.sh BUILD FOLDER SUITES - which share of the lines of each file of a folder the unit tests (those that match the pattern)
# and the fuzz targets run, the latter on their seeds and on what build/fuzz/corpus holds for them. BUILD is a config=coverage.
build=${1:?usage: tests/coverage.sh BUILD FOLDER SUITES}
folder=${2:-maps}
find "$build" -name '*.gcda' -delete
ENFILADE_BUILD=$build "$build/tests/all" -j"$(nproc)" --filter "${3:-*/*}" >"$build/tests/all.log" 2>&1 ||
    echo "not all tests pass: $build/tests/all.log"
for target in tests/fuzz_*.c; do
    name=$(basename "$target" .c)
    mapfile -t corpus < <(find tests/seeds "build/fuzz/corpus/${name#fuzz_}" -type f 2>/dev/null)
    "$build/tests/try_$name" 0 1 "${corpus[@]}" >"$build/tests/$name.log" 2>&1 || echo "fails: $build/tests/$name.log"
done
# `File 'maps/x.c'`, then `Lines executed:98.00% of 50`.
for object in "$build/$folder"/*.gcno; do
    gcov -n "$object" 2>/dev/null | awk -v folder="$folder/" '
        /^File/ { name = substr($2, 2, length($2) - 2) }
        /^Lines/ && index(name, folder) == 1 && name ~ /\.c$/ { split($0, p, /[:%]| of /); print name, p[2], p[4] }'
done | sort | awk '
    { printf "%-32s %6.2f %% of %5d\n", $1, $2, $3; lines += $3; run += $2 * $3 / 100 }
    END { printf "%-32s %6.2f %% of %5d\n", "all", 100 * run / (lines ? lines : 1), lines }'
