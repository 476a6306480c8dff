#!/bin/bash
# check_window.sh [--keep] - a walk through the house in a real window on a virtual screen (drive_window.py). What was
# said on the way is shown when something is wrong. With --keep its screenshots become the references.
. tests/checks.sh
for tool in Xvfb xdotool python3; do
    command -v $tool >/dev/null || skip "$tool is not installed"
done
server=
stop() {
    [ -z "$server" ] || { kill "$server"; wait "$server"; } 2>/dev/null
    rm -rf "$work"
}
trap stop EXIT
trap 'exit 1' INT TERM
export PYTHONDONTWRITEBYTECODE=1

python3 tests/window_driver.py || die 'the driver fails against its fake'

# The server says which display it took, and keeps its screen in a file that the driver reads.
mkfifo "$work/display"
# Without a reset when the last client leaves: the next one may come in the middle of it, and be refused.
Xvfb -noreset -displayfd 3 -screen 0 1400x900x24 -fbdir "$work" -nolisten tcp 3>"$work/display" 2>"$work/server" &
server=$!
read -r -t 20 display <"$work/display" || skip 'Xvfb does not start'
export DISPLAY=:$display
unset WAYLAND_DISPLAY

python3 tests/drive_window.py "$program" build/maps/house.plan "$work" "$work/Xvfb_screen0" tests/references "$@" \
    >"$work/log" 2>&1
status=$?
if [ $status -ne 0 ] || [ $# -gt 0 ]; then sed 's/^/check_window: /' "$work/log"; fi
exit $status
