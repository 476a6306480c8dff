#!/bin/bash
# check_levels.sh - `enfilade vis MAP.bsp`: levels of Quake and Quake II with their visibility, from outside.
. tests/app/checks.sh

level=$work/rooms.bsp
cp tests/seeds/rooms.bsp "$level"

# Rows of a level written once are those that a second run finds there; all on any number of threads. Nobody sees less than is proven.
expect 0 "$program" vis "$level" -o "$work/one.bsp" --threads 1
says out 'BSP29, 14 leaves; 14 cells and 9 portals of its leaves' && says out 'before a leaf saw 14.00 leaves'
expect 0 "$program" vis "$work/one.bsp" -o "$work/two.bsp" --threads 3
says out 'before a leaf saw 6.00 leaves in the mean; 0 pairs that see each other were missing'
same "$work/one.bsp" "$work/two.bsp" 'a second run, on other threads, writes another level'
same "$level" tests/seeds/rooms.bsp 'the level that was read is changed'
expect 0 "$program" vis --json tests/seeds/rooms-ii.bsp -o "$work/ii.bsp"
for key in rows cells portals visible proven undecided_cells visible_before missed_before bytes seconds; do says out "\"$key\": [0-9]"; done
says out '"format": "IBSP 38"' && says out '"portals_from": "leaves"' && says out '"stopped": false'

# What is appended to a level moves with its end, and is there whole.
[ "$(tail -c 6 "$work/one.bsp")" = 'a note' ] || fail 'what was appended is lost'

# In place only when asked for; a draft sees no less.
expect 0 "$program" vis "$level" --in-place && same "$level" "$work/one.bsp" 'in place is another level'
expect 0 "$program" vis "$level" -o "$work/fast.bsp" --fast
expect 0 "$program" vis "$work/fast.bsp" -o "$work/again.bsp" && says out ' 0 pairs that see each other were missing'
same "$work/again.bsp" "$work/one.bsp" 'rows depend on those before'
expect 0 "$program" vis "$level" -o "$work/early.bsp" --seconds 0.001 && says out 'bytes'
expect 0 "$program" vis "$level" -o "$work/water.bsp" --clear-water && says out '11 portals of its leaves'

# Stopped early, what was found is kept, and goes when all is found.
expect 0 "$program" vis "$level" -o "$work/early.bsp" --seconds 0.001 --state "$work/rooms.pairs"
if grep -q 'stopped early' "$work/out"; then [ -s "$work/rooms.pairs" ] || fail 'no state is kept'; fi
expect 0 "$program" vis "$level" -o "$work/last.bsp" --state "$work/rooms.pairs" && same "$work/last.bsp" "$work/one.bsp" 'going on'
[ ! -e "$work/rooms.pairs" ] || fail 'the state is left'
echo no state >"$work/rooms.pairs"
expect 1 "$program" vis "$level" -o "$work/last.bsp" --state "$work/rooms.pairs" && sentence
rm "$work/rooms.pairs"

# The portals of a compiler, beside the level or named; those of another level are refused, and nothing is written.
printf 'PRT1\n14\n1\n4 0 1 (0 0 9) (0 0 0) (0 9 0) (0 9 9)\n' >"$work/rooms.prt"
expect 1 "$program" vis "$level" -o "$work/no.bsp" && says err 'of its 1 portals 0 lie between other leaves' && sentence
printf 'PRT1\n3\n0\n' >"$work/other.prt"
expect 1 "$program" vis "$level" -o "$work/no.bsp" --portals "$work/other.prt" && says err 'has 3 leaves, .* has 14: it is not of this level'
expect 1 "$program" vis "$level" -o "$work/no.bsp" --portals "$work/other.prt" --clear-water && says err 'decides where water is clear'
[ ! -e "$work/no.bsp" ] || fail 'a level was written without its visibility'
expect 0 "$program" vis "$level" -o "$work/leaves.bsp" --portals leaves && same "$work/leaves.bsp" "$work/one.bsp" 'leaves'
rm "$work/rooms.prt"

# Damaged levels and full disks: one sentence, and the old file stays.
cp "$work/one.bsp" "$work/old.bsp"
head -c 3000 "$level" >"$work/cut.bsp"
expect 1 "$program" vis "$work/cut.bsp" -o "$work/old.bsp" && says err 'does not lie within the file of 3000 bytes' && sentence
expect 1 "$program" vis "$work/cut.bsp" --in-place && [ "$(wc -c <"$work/cut.bsp")" = 3000 ] || fail 'a damaged level was changed'
expect 1 "$program" vis $maps/house.plan -o "$work/old.bsp" && says err 'is no level of the Quake family'
expect 1 "$program" vis "$work/missing.bsp" -o "$work/old.bsp" && sentence
full_disk 1 "$program" vis "$level" -o "$work/old.bsp" && fail 'a full disk is no failure'
same "$work/old.bsp" "$work/one.bsp" 'an old level was touched'
expect 1 "$program" vis "$level" -o "$work/no/such/x.bsp" && sentence

# Wrong use.
expect 2 "$program" vis "$level" --in-place -o "$work/x.bsp" && says err 'writes MAP.bsp itself'
expect 2 "$program" vis "$level" --clear-water && says err 'are for levels'
expect 2 "$program" vis "$level" -o "$work/x.bsp" --pairs "$work/x.seen" && says err 'are about a matrix'
expect 2 "$program" vis "$level" -o "$work/x.bsp" --fast --pairs-method flow && says err 'is a method'
expect 2 "$program" vis "$level" -o "$work/x.bsb" && says err 'allowed'
exit $bad
