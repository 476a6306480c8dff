#!/bin/bash
# fresh_machine.sh [FOLDER [MIRROR]] - is a bare Debian 12 with git, make and apt enough? Makes one in FOLDER (default: a temporary one,
# removed at the end) by debootstrap, clones this checkout's last commit into it, and runs `make walk` and `make test` there. Needs root
# and a network. What was said is kept in build/fresh-machine.log; the last line tells how it went. Not run by `make test`.
set -eu
folder=${1:-}
mirror=${2:-http://deb.debian.org/debian}
fail() { echo "fresh_machine: $*" >&2; exit 1; }
[ "$(id -u)" = 0 ] || fail 'must be run by root: it makes a root of its own (allowed: sudo tests/fresh_machine.sh)'
command -v debootstrap >/dev/null || fail 'debootstrap is missing (apt-get install debootstrap)'
git diff --quiet HEAD || fail 'there are changes that are not committed: a clone would lack them'
root=${folder:-$(mktemp -d)}
log=$PWD/build/fresh-machine.log
mkdir -p build "$root"
leave() {
    umount "$root/proc" "$root/dev" 2>/dev/null || true
    # Never through what is still mounted.
    [ -n "$folder" ] || rm -rf --one-file-system "$root"
}
trap leave EXIT

echo "a bare Debian 12 in $root"
[ -e "$root/etc/debian_version" ] ||
    debootstrap --variant=minbase bookworm "$root" "$mirror" >"$log" 2>&1 || fail "debootstrap: see $log"
cp /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
rm -rf "$root/root/enfilade"
git clone -q --no-hardlinks . "$root/root/enfilade"

inside() {
    chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
        sh -c "cd /root/enfilade && $*" >>"$log" 2>&1
}
: >"$log"
inside "apt-get -q update && apt-get -q install -y --no-install-recommends git make ca-certificates" || fail "apt-get: see $log"
for goal in walk test; do
    echo "make $goal"
    inside "make $goal" || fail "make $goal: $(tail -1 "$log") (all of it: $log)"
done
[ -s "$root/root/enfilade/build/walk/house.mp4" ] || fail 'make walk left no video'
last=$(grep -E '^[0-9]+ passed, [0-9]+ failed, [0-9]+ skipped$' "$log" | tail -1)
[[ $last == *' 0 failed, '* ]] || fail "the tests say: $last"
# What is skipped says why: data or programs that are not there.
grep '^skipped: ' "$log" | sort | uniq -c | sort -rn | head -5
echo "a bare Debian 12: make walk and make test pass: $last"
