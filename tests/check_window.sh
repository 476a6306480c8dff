#!/bin/bash
# check_window.sh [--keep] - a walk through the house in a real window on a virtual screen (drive_window.py). What was
# said on the way is shown when something is wrong. With --keep its screenshots become the references.
set -u
program=$ENFILADE_BUILD/enfilade
for tool in Xvfb xdotool python3; do
    command -v $tool >/dev/null || { echo "check_window: $tool is not installed"; exit 77; }
done
work=$(mktemp -d)
server=
stop() {
    [ -z "$server" ] || { kill "$server"; wait "$server"; } 2>/dev/null
    rm -rf "$work"
}
trap stop EXIT
trap 'exit 1' INT TERM
export PYTHONDONTWRITEBYTECODE=1 XDG_CACHE_HOME=$work/cache

python3 tests/window_driver.py || { echo 'check_window: the driver fails against its fake'; exit 1; }

# The server says which display it took, and keeps its screen in a file that the driver reads.
mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1400x900x24 -fbdir "$work" -nolisten tcp 3>"$work/display" 2>"$work/server" &
server=$!
read -r -t 20 display <"$work/display" || { echo "check_window: Xvfb does not start"; exit 77; }
export DISPLAY=:$display
unset WAYLAND_DISPLAY

python3 tests/drive_window.py "$program" build/maps/house.plan "$work" "$work/Xvfb_screen0" tests/references "$@" \
    >"$work/log" 2>&1
status=$?
if [ $status -ne 0 ] || [ $# -gt 0 ]; then sed 's/^/check_window: /' "$work/log"; fi
exit $status
