# light.gp - from `enfilade bench light` (CSV, a row a building and way to bake): how right a bake's light is, against what it
# costs. Left, error against seconds, the ways by what they change; right, error against elements. The first building of the file.
# usage: gnuplot -e "csv='build/bench/light.csv'; out='build/pictures/light'" tests/plots/light.gp
# writes OUT.svg and OUT.png
set datafile separator ','
ways = "element per-patch residual resolution split reach default not-culled no-rows-kept"
titles = '"elements of 1 m to 0.17 m" "elements along a patch" "left to shoot" "resolution" "share of elements" "reach" "default" "not culled" "no rows kept"'
colours = "#3080c0 #208040 #d08020 #7a5fa8 #20a0a0 #a04080 #b02020 #606060 #909090"
marks = "7 9 5 11 15 6 13 3 8"
first = system(sprintf("sed -n '2s/,.*//p' %s", csv))
# A row's figure where it is of this way, else nothing.
of(way, figure) = strcol(1) eq first && strcol(2)[1:strlen(way)] eq way ? figure : NaN
set datafile missing NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,480 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,480 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,2
    set key top right samplen 2
    set title sprintf('%s: median error of what lit points gather', first)
    set xlabel 'seconds of bake, all cores'
    set ylabel 'percent of the irradiance there'
    plot for [w=1:9] csv every ::1 using 13:(of(word(ways, w), $19)) with linespoints pt int(word(marks, w)) ps 1.1 lw 2 lc rgb word(colours, w) title word(titles, w)
    set title 'medians over lit points'
    set xlabel 'elements'
    plot csv every ::1 using 9:(of('element', $19)) with linespoints pt 7 lw 2 lc rgb '#3080c0' title 'gathered at the point', \
        csv every ::1 using 9:(of('element', $26)) with linespoints pt 5 lw 2 lc rgb '#d08020' title 'of the element there', \
        csv every ::1 using 9:(of('element', $33)) with linespoints pt 9 lw 2 lc rgb '#208040' title 'between its corners'
    unset multiplot
    unset output
}
