#!/bin/bash
# check_fuzz.sh - every reader for two seconds on damaged files: no crash, no hang. `make fuzz` is the long run.
set -u
bad=0
seed=${ENFILADE_SEED:-1}
for target in "$ENFILADE_BUILD"/tests/try_fuzz_*; do
    [ -x "$target" ] || continue
    case $target in *.o | *.d) continue ;; esac
    timeout 60 "$target" 2 "$seed" tests/seeds/* maps/buildings/*.plan maps/buildings/*.sh3d tests/pictures/*.path \
        >"$ENFILADE_BUILD/tests/try_fuzz.log" 2>&1 && continue
    echo "check_fuzz: $target with seed $seed: $(tail -3 "$ENFILADE_BUILD/tests/try_fuzz.log")"
    bad=1
done
exit $bad
