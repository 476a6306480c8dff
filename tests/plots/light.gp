# light.gp - from `enfilade bench light` (CSV, a row a building and way to bake): how right a bake's light is, against what it
# costs. Above, as shooting goes on, culled, not culled, and without rows kept; and by how finely shooters are split and how far
# they are more than points. Below, all ways by what they change, and what a final gather costs and mends. The first building of
# the file. Beside each point stands the setting that it changes.
# usage: gnuplot -e "csv='build/bench/light.csv'; out='build/pictures/light'" tests/plots/light.gp
# writes OUT.svg and OUT.png
set datafile separator ','
set datafile missing NaN
first = system(sprintf("sed -n '2s/,.*//p' %s", csv))
is(way) = strcol(1) eq first && strcol(2)[1:strlen(way)] eq way
# A row's figure where it is of this way, else nothing; and what the way's name ends with.
of(way, figure) = is(way) ? figure : NaN
only(way, figure) = strcol(1) eq first && strcol(2) eq way ? figure : NaN
ending(way) = is(way) ? strcol(2)[strlen(way)+1:] : ''
array ways[5] = ['element-', 'residual-', 'resolution-', 'split-', 'final-gather-']
array titles[5] = ['elements, m', 'left to shoot', 'resolution', 'share of elements', 'final gather, resolution']
array colours[5] = [0x3080c0, 0xd08020, 0x7a5fa8, 0x20a0a0, 0x208040]
array marks[5] = [7, 5, 11, 15, 9]
black = 0x202020
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set format '%g'
# Errors lie within a power of ten or so: tics where they are wanted, between its ends.
set ytics (0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 8, 10, 12, 15, 20, 30)
set xtics (1, 2, 3, 5, 10, 20, 50, 100)
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,900 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,900 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 2,2
    set key top right samplen 2 opaque
    set xrange [1:100]
    set yrange [9:22]
    set xlabel 'CPU seconds of the bake, of all threads'
    set ylabel 'RMS of elements, percent of the mean'
    set title sprintf('%s: shooting until 0.1, 0.01, 0.001 of the light is left', first) noenhanced
    plot csv every ::1 using 40:(of('residual-', $28)) with linespoints pt 7 lw 2 lc rgb '#b02020' title 'culled', \
        csv every ::1 using 40:(of('not-culled-', $28)) with linespoints pt 5 lw 2 lc rgb '#3080c0' title 'not culled', \
        csv every ::1 using 40:(of('no-rows-kept-', $28)) with linespoints pt 9 lw 2 lc rgb '#208040' title 'culled, no rows kept', \
        for [w in "residual- not-culled- no-rows-kept-"] csv every ::1 using 40:(of(w, $28)):(ending(w)) with labels left offset 0.8,0.5 font ',8' tc rgb black notitle
    set yrange [2:10]
    set title 'how shooters are split: elements along a patch; reach in radii' noenhanced
    set ylabel 'median at lit points, between corners, percent'
    plot csv every ::1 using 40:(of('per-patch-', $33)) with linespoints pt 7 lw 2 lc rgb '#b02020' title 'elements along a patch', \
        csv every ::1 using 40:(of('reach-', $33)) with linespoints pt 5 lw 2 lc rgb '#3080c0' title 'reach', \
        csv every ::1 using 40:(only('default', $33)) with points pt 13 ps 1.5 lc rgb black title 'default: 2, 2', \
        for [w in "per-patch- reach-"] csv every ::1 using 40:(of(w, $33)):(ending(w)) with labels left offset 0.8,0.5 font ',8' tc rgb black notitle
    set yrange [*:*]
    set title 'what each setting buys' noenhanced
    set ylabel 'median at lit points, gathered there, percent'
    plot for [w=1:5] csv every ::1 using 40:(of(ways[w], $19)) with linespoints pt marks[w] ps 1.1 lw 2 lc rgb colours[w] title titles[w], \
        csv every ::1 using 40:(only('default', $19)) with points pt 13 ps 1.5 lc rgb black title 'default', \
        for [w=1:5] csv every ::1 using 40:(of(ways[w], $19)):(ending(ways[w])) with labels left offset 0.8,0.5 font ',8' tc rgb colours[w] notitle
    set yrange [2:30]
    set title 'a final gather at all vertices, or finer elements' noenhanced
    set ylabel 'median at lit points, between corners, percent'
    plot csv every ::1 using 40:(of('final-gather-', $33)) with linespoints pt 9 lw 2 lc rgb '#208040' title 'final gather, resolution', \
        csv every ::1 using 40:(of('element-', $33)) with linespoints pt 7 lw 2 lc rgb '#3080c0' title 'elements, m', \
        csv every ::1 using 40:(only('default', $33)) with points pt 13 ps 1.5 lc rgb black title 'default', \
        for [w in "final-gather- element-"] csv every ::1 using 40:(of(w, $33)):(ending(w)) with labels left offset 0.8,0.5 font ',8' tc rgb black notitle
    unset multiplot
    unset output
}
