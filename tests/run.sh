#!/bin/bash
# run.sh BUILD - runs the test binary BUILD/tests/all and every tests/app/check_*.sh, and ends with the one line
# `N passed, N failed, N skipped`. A script passes with 0, is skipped with 77, fails with anything else.
# Counts come from Criterion's TAP report: its closing line leaves skipped tests out.
build=${1:?usage: tests/run.sh BUILD}
tap=$build/tests/report.tap
logs=$build/tests/logs
rm -rf "$tap" "$logs"
mkdir -p "$logs"
export ENFILADE_BUILD=$build
export LSAN_OPTIONS=suppressions=tests/lsan.supp:print_suppressions=0 UBSAN_OPTIONS=print_stacktrace=1

"$build/tests/all" -j"$(nproc)" --tap="$tap"
status=$?
count() { grep -c "$1" "$tap" 2>/dev/null || true; }
planned=$(sed -n 's/^1\.\.\([0-9]*\)$/\1/p' "$tap" 2>/dev/null)
failed=$(count '^not ok ')
skipped=$(count '^ok .*# SKIP')
passed=$(($(count '^ok ') - skipped))
grep '^ok .*# SKIP' "$tap" 2>/dev/null | sed 's/^ok - /skipped: /; s/ *# SKIP/:/'
# A runner that dies leaves tests unreported; they count as failed.
unreported=$((${planned:-0} - passed - failed - skipped))
[ "$unreported" -gt 0 ] && failed=$((failed + unreported))
[ $status -ne 0 ] && [ $failed -eq 0 ] && failed=1

run() {
    local log
    log=$logs/$(basename "$1" .sh)
    bash "$1" >"$log" 2>&1 </dev/null
    echo $? >"$log.status"
}
# The one in the window takes as long as all others and waits half of that time: they run beside it. Not the binary, which takes all
# cores: what a window does is also a question of time. What each says is told when all are through.
window=tests/app/check_window.sh
others=$(ls tests/app/check_*.sh | grep -vx $window)
scripts="$window $others"
set -m  # a group of its own, so that Ctrl-C ends it whole
run $window &
beside=$!
set +m
trap 'kill -TERM -- -$beside 2>/dev/null; exit 1' INT TERM
for script in $others; do run "$script"; done
wait $beside
for script in $scripts; do
    log=$logs/$(basename "$script" .sh)
    cat "$log"
    case $(cat "$log.status") in
    0) passed=$((passed + 1)) ;;
    77) skipped=$((skipped + 1)) && echo "skipped: $script" ;;
    *) failed=$((failed + 1)) && echo "failed: $script" ;;
    esac
done
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ] && [ $((passed + skipped)) -gt 0 ]
