#!/bin/bash
# check_budgets.sh - small files do not take the machine. Work and memory of what opens them are counted at n, 2n and 4n
# (hostile_cost.c); at soak every kind of file is opened at its full size and at the half, with two seeds, by the program, within 10 s of CPU
# and 1 GB, and is refused with one sentence at most where the kind allows it. Its stab trees take 20 s at most.
. tests/app/checks.sh
make -s config=counted build/counted/tests/hostile_cost >"$work/log" 2>&1 || die "hostile_cost cannot be built: $(tail -3 "$work/log")"
build/counted/tests/hostile_cost >"$work/log" || fail "$(grep -vE 'bytes, edges' "$work/log")"
[ -n "${ENFILADE_SOAK:-}" ] || exit $bad

make=$build/tests/make_hostile
# within SECONDS COMMAND...: runs the program on the file; sets `code`
within() {
    local seconds=$1
    shift
    rm -rf "$work/cache"
    (ulimit -t "$seconds"; exec /usr/bin/time -f %M -o "$work/peak" "$program" "$@") >"$work/out" 2>"$work/err" </dev/null
    code=$?
}
# try KIND SUFFIX COUNT SEED MAY
try() {
    local file=$work/$1$2 what="$1 of $3, seed $4" code seconds
    "$make" "$1" "$3" "$4" "$file"
    for seconds in 10 20; do
        if [ $seconds = 10 ]; then within 10 info "$file"; else within 20 vis "$file" -o "$work/trees.vis"; fi
        case $code in
        0) ;;
        1) [ "$5" = may-refuse ] && sentence || fail "$what: $(head -1 "$work/err")" ;;
        *) fail "$what: status $code in $seconds s" ;;
        esac
        [ "$(tail -1 "$work/peak")" -le 1000000 ] || fail "$what: takes $(tail -1 "$work/peak") kB"
    done
    rm -f "$file"
}
[ -x /usr/bin/time ] || die 'the Debian package time is not here'
while read -r kind suffix count may; do
    for seed in 1 2; do
        try "$kind" "$suffix" "$count" $seed "$may"
        try "$kind" "$suffix" $((count / 2)) $seed "$may"
    done
done < <("$make")
exit $bad
