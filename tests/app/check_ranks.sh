#!/bin/bash
# check_ranks.sh - light in parts, by several processes: the same bytes by any number of them. Needs the program of `make mpi=1` and mpirun.
. tests/app/checks.sh

several=build/release-mpi/enfilade
[ -x $several ] && command -v mpirun >/dev/null || { echo "no program made by make mpi=1, or no mpirun"; exit 77; }
ranks() { expect "$1" mpirun --allow-run-as-root --oversubscribe -n "$2" $several bake $maps/house.plan --night --element 0.8 --residual 0.01 --parts 16 "${@:3}"; }
ranks 0 1 -o "$work/1.rad" --threads 1
for n in 2 4; do
    ranks 0 $n -o "$work/$n.rad" --threads 1 --json && says out "\"ranks\": $n" && says out '"sent_mb": [1-9]'
    same "$work/1.rad" "$work/$n.rad" "$n processes make another light than one"
done
# The same without mpirun, and by the program without MPI.
expect 0 "$program" bake $maps/house.plan --night --element 0.8 --residual 0.01 --parts 16 -o "$work/none.rad"
same "$work/1.rad" "$work/none.rad" 'mpirun changes the light'
# More processes than parts; a file that is not there: one sentence, and all end.
ranks 1 2 -o "$work/x.rad" --parts 1000 && says err 'give --parts with fewer cells'
expect 1 mpirun --allow-run-as-root --oversubscribe -n 2 $several bake "$work/absent.plan" && says err 'absent.plan'
[ ! -e "$work/x.rad" ] || fail 'a file of light of a bake that was refused'
exit $bad
