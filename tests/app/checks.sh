# checks.sh - what the tests of the program from outside share; each check_*.sh begins with `. tests/app/checks.sh`. Gives it the program,
# the sample buildings, a scratch folder that goes when it ends, with a cache of its own in it, and what to say when something is wrong.
set -u
script=$(basename "$0" .sh)
build=${ENFILADE_BUILD:-build/release}
program=$build/enfilade
maps=build/maps
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME=$work/cache
bad=0  # what the script exits with

# fail WORDS: tells what is wrong and goes on; die WORDS ends the script with it; skip WORDS ends it as skipped.
fail() { echo "$script: $*"; bad=1; }
die() { fail "$@"; exit 1; }
skip() { echo "$script: $*"; exit 77; }

# expect STATUS COMMAND...: runs it, output in $work/out and $work/err.
expect() {
    local status=$1 got
    shift
    "$@" >"$work/out" 2>"$work/err" </dev/null
    got=$?
    [ $got -eq "$status" ] || fail "$* exits $got, not $status: $(head -2 "$work/err")"
}
# says out|err PATTERN: of the last command's output.
says() { grep -q -- "$2" "$work/$1" || fail "no \`$2\` in $1: $(head -2 "$work/$1")"; }
quiet() { [ ! -s "$work/err" ] || fail "standard error should be empty: $(head -2 "$work/err")"; }
# sentence: all that was said on standard error is one line.
sentence() { [ "$(wc -l <"$work/err")" -eq 1 ] || fail "not one sentence: $(head -3 "$work/err")"; }
# same FILE FILE SENTENCE: byte for byte, or it fails with the sentence.
same() { cmp -s "$1" "$2" || fail "$3"; }
# full_disk BLOCKS COMMAND...: files end after so many kB, as on a disk that is full.
full_disk() { (trap '' XFSZ; ulimit -f "$1"; shift; exec "$@") >/dev/null 2>"$work/err"; }
# cpu PID: hundredths of a second of CPU that a process has taken so far. What waits for them waits longer on a busy machine.
cpu() { awk '{ print $14 + $15 }' "/proc/$1/stat" 2>/dev/null || echo 100000; }
# started PID: waits until the process that was begun with `&` runs its program: until then it is a shell, which a signal would end as this
# script ends, its scratch folder with it.
started() { while [ "$(cat "/proc/$1/comm" 2>/dev/null)" = bash ]; do sleep 0.01; done; }
# start_screen: a virtual screen, named by DISPLAY, whose pixels are in "$work/Xvfb_screen0"; it goes when the script ends.
start_screen() {
    command -v Xvfb >/dev/null || skip 'Xvfb is not installed'
    mkfifo "$work/display"
    # Without a reset when the last client leaves: the next one may come in the middle of it, and be refused.
    Xvfb -noreset -displayfd 3 -screen 0 1400x900x24 -fbdir "$work" -nolisten tcp 3>"$work/display" 2>"$work/server" &
    screen=$!
    trap '{ kill $screen; wait $screen; } 2>/dev/null; rm -rf "$work"' EXIT
    trap 'exit 1' INT TERM
    # The server says which display it took.
    read -r -t 20 display <"$work/display" || skip 'Xvfb does not start'
    export DISPLAY=:$display PYTHONDONTWRITEBYTECODE=1
    unset WAYLAND_DISPLAY
}
