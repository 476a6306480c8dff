#!/bin/bash
# check_no_memory.sh - where a request for memory by anyone, libraries included, finds none (fail_malloc.c; those of our own have
# test_no_memory.c). The program ends with a sentence and status 1, or comes to the same result without that memory, and leaves no
# half of a file. What aborts inside a library is counted and told; the libraries that may are in tests/README.md.
. tests/app/checks.sh
[ "$(basename "$build")" = asan ] && skip "the sanitizer has an allocator of its own"
times=4
[ -n "${ENFILADE_SOAK:-}" ] && times=150
seed=1
RANDOM=$seed
fail_so=$work/fail_malloc.so
${CC:-gcc} -D_GNU_SOURCE -O1 -shared -fPIC -o "$fail_so" tests/core/fail_malloc.c || die "fail_malloc.c does not compile"
export FAIL_LOG=$work/log MESA_SHADER_CACHE_DISABLE=true

# try COMMAND...: what it writes is $work/new/x; what it wrote without a failure is $work/x.
try() {
    local at total status who
    mkdir -p "$work/new"
    FAIL_AT=0 LD_PRELOAD=$fail_so "$program" "$@" >/dev/null 2>"$work/err" || die "$* fails: $(cat "$work/err")"
    total=$(cat "$FAIL_LOG")
    mv "$work/new/x" "$work/x" 2>/dev/null
    for ((i = 0; i < times; i++)); do
        at=$(((RANDOM * 32768 + RANDOM) % total + 1))
        rm -rf "$FAIL_LOG" "$work/new" "$work/cache"
        mkdir "$work/new"
        # Bash would tell of each that crashes.
        { FAIL_AT=$at LD_PRELOAD=$fail_so timeout 300 "$program" "$@" >/dev/null 2>"$work/err"; } 2>/dev/null
        status=$?
        who=$(sed 's/^fail_malloc.so //; s/^\(libstdc++[^ ]*\|libc.so.6\) //; s/ .*//' "$FAIL_LOG" 2>/dev/null)
        case $status in
        0) [ ! -e "$work/x" ] || same "$work/x" "$work/new/x" "$*: request $at, of $who, changes the result" ;;
        1) grep -q '^enfilade: ' "$work/err" || fail "$*: request $at, of $who, ends without a sentence" ;;
        124) fail "$*: request $at, of $who, hangs" ;;
        *) case $who in
            libLLVM* | libOSMesa* | libgeos_c*) ;; # crash, abort, or are in GEOS_init_r
            *) fail "$*: request $at, of $who, ends with status $status" ;;
            esac ;;
        esac
        [ "$status" -eq 0 ] || [ ! -e "$work/new/x" ] || same "$work/x" "$work/new/x" "$*: request $at leaves half a file"
        echo "$1: status $status, a request of ${who:-nobody}"
    done >>"$work/tally"
    rm -f "$work/x"
}

try info $maps/two-rooms.plan
try vis $maps/house.sh3d -o "$work/new/x"
try vis $maps/two-rooms.plan -o "$work/new/x"
try bake $maps/two-rooms.plan --element 2 --refine 0 --shots 3 -o "$work/new/x"
"$program" bake $maps/two-rooms.plan --element 2 --refine 0 --shots 3 -o "$work/light.rad" >/dev/null 2>&1
try render $maps/two-rooms.plan --size 64x48 --light "$work/light.rad" -o "$work/new/x"
[ -z "${ENFILADE_SOAK:-}" ] || try walk $maps/two-rooms.plan --size 64x48 --tour window --offscreen "$work/new/frames"
# What happened to whom, for tests/README.md.
grep -v '^check_' "$work/tally" | sort | uniq -c
[ $bad -eq 0 ] || grep '^check_' "$work/tally"
echo "seed $seed"
exit $bad
