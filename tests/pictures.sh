#!/bin/bash
# pictures.sh BUILD - the pictures of the README, drawn anew into tests/pictures; some minutes.
set -e
build=${1:?usage: tests/pictures.sh BUILD}
mkdir -p build/pictures tests/pictures
for view in living kitchen courtyard study; do
    "$build/enfilade" walk build/maps/house.plan --size 1200x675 \
    --offscreen build/pictures/$view --tour $view
done
montage build/pictures/living/frame-00000.png build/pictures/kitchen/frame-00000.png build/pictures/courtyard/frame-00000.png build/pictures/study/frame-00000.png -tile 2x2 -geometry 600x338+3+3 \
    -depth 8 -colors 200 tests/pictures/house.png
"$build/enfilade" render maps/buildings/studio.plan --view corner --size 600x338 -o build/pictures/day-studio.png
for view in living kitchen bedroom; do
    "$build/enfilade" render build/maps/house.plan --view $view --size 600x338 -o build/pictures/day-$view.png
done
montage build/pictures/day-studio.png build/pictures/day-living.png build/pictures/day-kitchen.png build/pictures/day-bedroom.png \
    -tile 2x2 -geometry 600x338+3+3 -depth 8 -colors 200 tests/pictures/homes.png
for view in studio maze; do
    "$build/enfilade" walk maps/buildings/mirrors.plan --look fine --size 1200x675 \
    --offscreen build/pictures/mirrors-$view --tour $view
done
montage build/pictures/mirrors-studio/frame-00000.png build/pictures/mirrors-maze/frame-00000.png -tile 2x1 -geometry 600x338+3+3 \
    -depth 8 -colors 160 tests/pictures/mirrors.png
"$build/enfilade" plan build/maps/two-rooms.plan --from 1,1,1.5 --width 800 -o build/pictures/plan.svg
rsvg-convert build/pictures/plan.svg -o tests/pictures/plan.png
# The film replays a recorded path, which holds for house.plan as it is: after a change record another in the window.
rm -rf build/pictures/film
"$build/enfilade" walk build/maps/house.plan --replay tests/pictures/walk.path --bake --offscreen build/pictures/film \
    --size 480x270 --every 6
ffmpeg -loglevel error -y -framerate 10 -i build/pictures/film/frame-%05d.png -t 16 -vf "fps=8,scale=360:-1:flags=lanczos,\
split[a][b];[a]palettegen=max_colors=128:stats_mode=full[p];[b][p]paletteuse=dither=bayer:bayer_scale=5:diff_mode=rectangle" \
    tests/pictures/walk.gif
"$build/enfilade" bake build/maps/house.plan --lamps each -o build/pictures/house.rad
shot=0
for lamps in on off,table-lamp=on off,hall=on 'off,floor-lamp=60%#ff7030,globe-lamp=on'; do
    "$build/enfilade" walk build/maps/house.plan --light build/pictures/house.rad --lamps "$lamps" \
    --size 800x450 --offscreen build/pictures/lamps-$((shot += 1)) --tour living
done
montage build/pictures/lamps-[1-4]/frame-00000.png -tile 2x2 -geometry 480x270+2+2 -depth 8 -colors 96 tests/pictures/lamps.png
# A door opens into a room whose lamp is off, and closes again: each frame is the light of its state.
frame=0
rm -f build/pictures/door-*.png build/pictures/door-*.rad
for open in 0 0 3 6 10 15 21 28 36 45 55 66 78 90 100 100 100 90 78 66 55 45 36 28 21 15 10 6 3 0; do
    light=build/pictures/door-$open.rad
    [ -e "$light" ] || "$build/enfilade" bake build/maps/two-rooms.plan --night --doors between=$open% --lamps study=off -o "$light"
    "$build/enfilade" render build/maps/two-rooms.plan --light "$light" --lamps study=off --eye 1.6,0.4,1.6 --look 4.2,1.6,0.9 \
    --fov 80 --size 720x406 --exposure 0.7 -o "$(printf build/pictures/door-%05d.png $frame)"
    : $((frame += 1))
done
ffmpeg -loglevel error -y -framerate 10 -i build/pictures/door-%05d.png -vf "scale=360:-1:flags=lanczos,split[a][b];\
[a]palettegen=max_colors=96:stats_mode=full[p];[b][p]paletteuse=dither=bayer:bayer_scale=5:diff_mode=rectangle" \
    tests/pictures/door.gif
for view in living bedroom kitchen; do
    "$build/enfilade" walk build/maps/house.plan --light build/pictures/house.rad \
    --size 800x450 --offscreen build/pictures/baked-$view --tour $view
done
montage build/pictures/baked-bedroom/frame-00000.png build/pictures/baked-kitchen/frame-00000.png -tile 2x1 -geometry 600x338+0+0 \
    -depth 8 -colors 200 tests/pictures/baked.png
"$build/enfilade" walk build/maps/house.plan --light build/pictures/house.rad --false-colour illuminance \
    --size 800x450 --offscreen build/pictures/lux-living --tour living
montage build/pictures/baked-living/frame-00000.png build/pictures/lux-living/frame-00000.png -tile 2x1 \
    -geometry 600x338+0+0 -depth 8 -colors 200 tests/pictures/lit.png
"$build/enfilade" render build/maps/house.plan --light build/pictures/house.rad --view still --samples 64 \
    -o build/pictures/still.png
convert build/pictures/still.png -strip -define png:compression-level=9 tests/pictures/still.png
# Errors of what is shown, and the same view: where one begins. The truth is coarse: minutes of path tracing even so.
"$build/enfilade" bench light build/maps/office-plain.plan --methods default --points 1 --error 0.5 --size 96x54 \
    --pictures build/pictures >build/pictures/light-error.csv
"$build/enfilade" bake build/maps/office-plain.plan -o build/pictures/office-plain.rad
"$build/enfilade" walk build/maps/office-plain.plan --light build/pictures/office-plain.rad --size 480x270 \
    --offscreen build/pictures/office-plain --every 100000
rsvg-convert build/pictures/light-error-scale.svg -o build/pictures/light-error-scale.png
montage build/pictures/office-plain/frame-00000.png '(' build/pictures/default-error.png -filter point -resize \
    480x270 ')' -tile 2x1 -geometry 480x270+3+3 -depth 8 miff:- | convert - build/pictures/light-error-scale.png \
    -gravity center -append -colors 128 tests/pictures/light-error.png
"$build/enfilade" bench radiosity --pictures build/pictures >build/pictures/radiosity.csv
montage build/pictures/doi-itoh-2-hemicube.png build/pictures/doi-itoh-2-hemisphere.png -tile 2x1 -geometry +3+3 \
    -colors 128 tests/pictures/hemicube-hemisphere.png
montage tests/references/hall-plan.png tests/references/hall-wireframe.png tests/references/lookout-frozen.png \
    -tile 3x1 -geometry +3+3 tests/pictures/debug.png
