#!/bin/bash
# check_fuzz.sh - every reader for two seconds on damaged files: no crash, no hang. `make fuzz` is the long run.
. tests/app/checks.sh
seed=${ENFILADE_SEED:-1}
for target in "$build"/tests/try_fuzz_*; do
    [ -x "$target" ] || continue
    case $target in *.o | *.d) continue ;; esac
    timeout 60 "$target" 2 "$seed" tests/seeds/* maps/buildings/*.plan maps/buildings/*.sh3d tests/pictures/*.path \
        >"$work/log" 2>&1 || fail "$target with seed $seed: $(tail -3 "$work/log")"
done
exit $bad
