#!/bin/bash
# check_window.sh [--keep] - a walk through the house in a real window on a virtual screen (drive_window.py). What was
# said on the way is shown when something is wrong. With --keep its screenshots become the references.
. tests/app/checks.sh
for tool in xdotool python3; do
    command -v $tool >/dev/null || skip "$tool is not installed"
done
start_screen
python3 tests/app/window_driver.py || die 'the driver fails against its fake'

python3 tests/app/drive_window.py "$program" build/maps/house.plan "$work" "$work/Xvfb_screen0" tests/references "$@" \
    >"$work/log" 2>&1
status=$?
if [ $status -ne 0 ] || [ $# -gt 0 ]; then sed 's/^/check_window: /' "$work/log"; fi
exit $status
