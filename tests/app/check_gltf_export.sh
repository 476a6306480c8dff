#!/bin/bash
# check_gltf_export.sh - exported models pass the Khronos validator without an error, a warning or a hint. Skipped where node, or
# its module gltf-validator (npm install gltf-validator, found by NODE_PATH or in a node_modules above), is not there.
. tests/app/checks.sh
node -e 'require("gltf-validator")' 2>/dev/null || skip 'the node module gltf-validator is not here'
cat >"$work/validate.js" <<'END'
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 100 }).then(report => {
    for (const m of report.issues.messages) console.log(m.code, m.pointer, m.message);
    process.exit(report.issues.messages.length > 0 || report.info.totalTriangleCount == 0 ? 1 : 0);
});
END
for file in build/maps/two-rooms.plan build/maps/house.plan build/maps/house.sh3d tests/seeds/room.glb tests/seeds/room.quads \
    build/maps/flat.Home.xml build/maps/hillside.sh3d maps/buildings/attic.sh3d maps/buildings/textures.sh3d \
    ../shared/data/sh3d/2BedroomHouseWithBasement.Home.xml ../shared/data/radiosity/twoRoom.quads; do
    [ -e "$file" ] || continue
    day=
    case $file in *attic.sh3d | *textures.sh3d) day=--day ;; esac  # no lamps, but pictures all over
    for doors in drawn closed open; do
        # A building without lamps has no light.
        "$program" bake "$file" -o "$work/x.glb" --element 0.7 --residual 0.1 --doors $doors $day >"$work/out" 2>&1 || {
            grep -q 'nothing emits light' "$work/out" && continue
            fail "$file: $(head -2 "$work/out")"
        }
        NODE_PATH=${NODE_PATH:-}:$PWD/node_modules node "$work/validate.js" "$work/x.glb" >"$work/out" && continue
        fail "$file, doors $doors: $(head -3 "$work/out")"
    done
done
exit $bad
