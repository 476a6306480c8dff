#!/bin/bash
# outputs.sh BUILD [--keep] - the bytes of what the program makes: `.vis`, `.rad`, stills, and the counts of benchmarks, of our sample
# buildings and of three real homes (skipped where their folder is not beside the project). Compares their hashes with
# references/outputs.txt, whose second column tells the output; --keep writes that file anew. For changes that must not change any
# result. The bytes hold for one machine flag set (-march), one libm and one Mesa; a few minutes of CPU.
set -u
build=${1:?usage: tests/outputs.sh BUILD [--keep]}
keep=${2:-}
list=tests/references/outputs.txt
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_CACHE_HOME=$folder/cache
enfilade=$build/enfilade
homes=../shared/data/sh3d
hash() { printf '%s  %s\n' "$(sha256sum <"$1" | cut -c1-32)" "$2"; }
# A table without the columns that tell times, bytes of memory, rates, and which rows are ahead by time.
counts() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) drop[i] = $i ~ /(^|_)(ms|us|ns|s|seconds|kb|mb|second)(_|$)|^front$/ }
             { line = ""; for (i = 1; i <= NF; i++) if (!drop[i]) line = line "," $i; print line }'
}
make_outputs() {
    local building name
    for building in build/maps/{two-rooms.plan,house.sh3d,office.plan,hillside.sh3d,villa.sh3d} \
        $homes/{2-BedroomApartment.sh3d,4-BedroomHouse.sh3d,2BedroomHouseWithBasement.Home.xml}; do
        [ -e "$building" ] || continue
        name=$(basename "$building")
        "$enfilade" vis "$building" -o "$folder/vis" >"$folder/out" 2>&1 || cat "$folder/out" >&2
        hash "$folder/vis" "$name.vis"
        "$enfilade" bake "$building" --shots 200 -o "$folder/a.rad" >"$folder/out" 2>&1 || cat "$folder/out" >&2
        hash "$folder/a.rad" "$name.rad"
        "$enfilade" render "$building" --light "$folder/a.rad" --size 160x90 --samples 4 -o "$folder/a.png" >"$folder/out" 2>&1 ||
            cat "$folder/out" >&2
        hash "$folder/a.png" "$name.png"
        for table in walk collision visibility; do
            "$enfilade" bench $table "$building" 2>"$folder/out" | counts >"$folder/csv"
            hash "$folder/csv" "$name.$table.csv"
        done
    done
    for table in formfactors hidden radiosity; do
        "$enfilade" bench $table build/maps/two-rooms.plan 2>"$folder/out" | counts >"$folder/csv"
        hash "$folder/csv" "$table.csv"
    done
}
make_outputs >"$folder/list"
if [ "$keep" = --keep ]; then
    cp "$folder/list" $list
    exit 0
fi
# Only what was made: homes may be absent.
awk 'NR == FNR { made[$2] = $1; next } $2 in made && made[$2] != $1 { print "changed: " $2; bad = 1 } $2 in made { n++ }
     END { print n " outputs compared"; exit bad || !n }' "$folder/list" $list
