#!/bin/sh
# exports.sh HEADERS_FOLDER OBJECTS... - the library's names, a line each: of all that the objects define those that the
# installed headers speak of.
headers=$1
shift
words=$(mktemp)
trap 'rm -f "$words"' EXIT
find "$headers" -name '*.h' -exec cat {} + | grep -oE '[A-Za-z_][A-Za-z_0-9]*' | LC_ALL=C sort -u >"$words"
nm -g --defined-only "$@" | awk 'NF == 3 { print $3 }' | LC_ALL=C sort -u | LC_ALL=C comm -12 - "$words"
