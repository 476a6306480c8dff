# light.gp - from `enfilade bench light` (CSV, a row a building and way to bake): how right a bake's light is, against what it
# costs. Above, as shooting goes on, culled, not culled, and without rows kept; and by how finely shooters are split and how far
# they are more than points. Below, all ways by what they change, and what a final gather costs and mends. The first building of
# the file.
# usage: gnuplot -e "csv='build/bench/light.csv'; out='build/pictures/light'" tests/plots/light.gp
# writes OUT.svg and OUT.png
set datafile separator ','
set datafile missing NaN
first = system(sprintf("sed -n '2s/,.*//p' %s", csv))
# A row's figure where it is of this way, else nothing.
of(way, figure) = strcol(1) eq first && strcol(2)[1:strlen(way)] eq way ? figure : NaN
only(way, figure) = strcol(1) eq first && strcol(2) eq way ? figure : NaN
ways = "element residual resolution split final-gather default"
titles = '"elements of 1 m to 0.17 m" "left to shoot" "resolution" "share of elements" "final gather" "default"'
colours = "#3080c0 #d08020 #7a5fa8 #20a0a0 #208040 #b02020"
marks = "7 5 11 15 9 13"
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,860 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,860 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 2,2
    set key top right samplen 2
    set xlabel 'seconds of bake, all cores'
    set ylabel 'RMS of elements, percent of the mean'
    set title sprintf('%s: 10 %% to 0.1 %% left to shoot', first) noenhanced
    plot csv every ::1 using 13:(of('residual-', $28)) with linespoints pt 7 lw 2 lc rgb '#b02020' title 'culled', \
        csv every ::1 using 13:(of('not-culled-', $28)) with linespoints pt 5 lw 2 lc rgb '#3080c0' title 'not culled', \
        csv every ::1 using 13:(of('no-rows-kept-', $28)) with linespoints pt 9 lw 2 lc rgb '#208040' title 'culled, no rows kept'
    set title 'shooters: elements along a patch 1, 2, 4; reach in radii 0, 1, 3' noenhanced
    set ylabel 'median at lit points, between corners, percent'
    plot csv every ::1 using 13:(of('per-patch-', $33)) with linespoints pt 7 lw 2 lc rgb '#b02020' title 'elements along a patch', \
        csv every ::1 using 13:(of('reach-', $33)) with linespoints pt 5 lw 2 lc rgb '#3080c0' title 'reach', \
        csv every ::1 using 13:(only('default', $33)) with points pt 13 ps 1.5 lc rgb '#202020' title 'default'
    set title 'what each setting buys' noenhanced
    set ylabel 'median at lit points, gathered there, percent'
    plot for [w=1:6] csv every ::1 using 13:(of(word(ways, w), $19)) with linespoints pt int(word(marks, w)) ps 1.1 lw 2 lc rgb word(colours, w) title word(titles, w)
    set title 'final gather at all vertices, resolution 25, 50, 100' noenhanced
    set ylabel 'median at lit points, between corners, percent'
    plot csv every ::1 using 13:(of('final-gather-', $33)) with linespoints pt 9 lw 2 lc rgb '#208040' title 'final gather', \
        csv every ::1 using 13:(of('element-', $33)) with linespoints pt 7 lw 2 lc rgb '#3080c0' title 'finer elements instead', \
        csv every ::1 using 13:(only('default', $33)) with points pt 13 ps 1.5 lc rgb '#b02020' title 'default'
    unset multiplot
    unset output
}
