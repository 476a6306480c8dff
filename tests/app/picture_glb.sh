#!/bin/bash
# picture_glb.sh [BUILDING VIEWPOINT...] - tests/pictures/exported.png: our own frames of a baked building on the left, those of its
# exported model by three.js in headless Chromium on the right (render_glb.js, which says what it needs), from the same viewpoints.
set -eu
building=${1:-build/maps/house.plan}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- kitchen living
program=${ENFILADE_BUILD:-build/release}/enfilade
out=build/pictures/exported
mkdir -p $out tests/pictures
# Doors as a tour has them.
"$program" bake "$building" --doors open -o $out/x.rad -o $out/x.glb
frames=()
for view in "$@"; do
    "$program" walk "$building" --light $out/x.rad --size 800x450 --offscreen "$out/$view" --tour "$view"
    node tests/app/render_glb.js $out/x.glb "$view" 800x450 "$out/$view.png"
    frames+=("$out/$view/frame-00000.png" "$out/$view.png")
done
montage "${frames[@]}" -tile 2x -geometry 480x270+2+2 -depth 8 tests/pictures/exported.png
