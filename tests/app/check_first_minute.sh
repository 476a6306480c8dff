#!/bin/bash
# check_first_minute.sh - what a newcomer meets in a real window on a virtual screen (drive_first_minute.py). What was said on the way is
# shown when something is wrong.
. tests/app/checks.sh
for tool in xdotool python3; do
    command -v $tool >/dev/null || skip "$tool is not installed"
done
start_screen
home=../shared/data/sh3d/4-BedroomHouse.sh3d
[ -r $home ] || home=

python3 tests/app/drive_first_minute.py "$program" build/maps/house.plan "$work" "$work/Xvfb_screen0" $home >"$work/log" 2>&1
status=$?
if [ $status -ne 0 ] || [ $# -gt 0 ]; then sed 's/^/check_first_minute: /' "$work/log"; fi
exit $status
