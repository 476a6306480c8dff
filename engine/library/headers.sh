#!/bin/sh
# headers.sh FOLDER - puts the public headers into FOLDER: enfilade.h and all that it includes, under their own paths. Includes
# between them become <enfilade/...>, so that they find each other wherever they are installed.
set -e
folder=$1
for header in $(gcc -MM -I. -x c engine/library/enfilade.h | tr -d '\\\n' | cut -d: -f2); do
    place=$folder/${header#engine/library/}
    mkdir -p "$(dirname "$place")"
    sed 's|^#include "\(.*\)"|#include <enfilade/\1>|' "$header" >"$place"
    chmod 644 "$place"
done
