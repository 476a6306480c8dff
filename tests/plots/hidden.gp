# hidden.gp - from `enfilade bench hidden` (CSV, a row a table, scene and method): time of each hidden-surface method against
# polygons, depth complexity and resolution; memory; where sorting by centroids fails; buildings, culled and not.
# usage: gnuplot -e "csv='build/bench/hidden.csv'; out='build/pictures/hidden'" tests/plots/hidden.gp
# writes OUT.svg and OUT.png
set datafile separator ','
methods = "zbuffer scanline centroid-sort depth-sort bsp warnock raycast raycast-grid embree osmesa"
colours = "#b02020 #3080c0 #909090 #d08020 #7a5fa8 #208040 #202020 #80b060 #b0a0d0 #60a0a0"
marks = "13 7 2 5 9 11 6 4 10 3"
# A row's figure where it is of this table and method, else nothing.
of(t, m, figure) = strcol(1) eq t && strcol(7) eq word(methods, m) ? figure : NaN
# The building's place on the axis, and the method's beside it.
buildings = "two-rooms.plan house.plan office.plan office-plain.plan"
place(name) = (name eq word(buildings, 1)) ? 1 : (name eq word(buildings, 2)) ? 2 : (name eq word(buildings, 3)) ? 3 : 4
set datafile missing NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1300,860 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1300,860 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 2,3 margins 0.06,0.98,0.08,0.86 spacing 0.07,0.14
    set logscale xy
    set format y '10^{%L}'
    do for [panel=1:4] {
        t = word("polygons depth resolution polygons", panel)
        along = int(word("3 4 5 3", panel))
        up = panel == 4 ? 11 : 9
        set xlabel panel == 2 ? "depth complexity" : panel == 3 ? "pixels a side" : "polygons"
        if (panel == 1) { set ylabel 'ms a picture of 512 x 512, depth complexity 4'; set xrange [80:80000] }
        if (panel == 2) { set ylabel 'ms, 2,500 polygons'; set xrange [0.9:20] }
        if (panel == 3) { set ylabel 'ms, 2,500 polygons'; set xrange [55:1200] }
        if (panel == 4) { set ylabel 'kB beside scene and item buffer'; set xrange [80:80000] }
        if (panel == 1) { set key at screen 0.5,0.98 center top horizontal maxcols 5 samplen 2 } else { unset key }
        plot for [m=1:words(methods)] csv every ::1 using (column(along)):(of(t, m, column(up))) with linespoints pt int(word(marks, m)) lw 1.5 lc rgb word(colours, m) title word(methods, m)
    }
    unset logscale
    set format y '%g'
    set xlabel 'depth complexity'
    set ylabel 'share of pixels that centroid-sort gets wrong'
    set xrange [0:18]
    set yrange [0:*]
    plot csv every ::1 using 4:(of('depth', 3, $10)) with linespoints pt 2 lw 2 lc rgb '#909090'
    set logscale y
    set yrange [*:*]
    set format y '10^{%L}'
    set xlabel 'pale: all polygons; full: those that the stab trees leave'
    set ylabel 'ms a picture of 640 x 360'
    set xrange [0.5:4.6]
    set xtics ("two-rooms" 1, "house" 2, "office" 3, "office-plain" 4)
    plot for [m=1:words(methods)] csv every ::1 using (place(strcol(2)) + 0.08 * (m - 5)):(of('unculled', m, $9)) with points pt int(word(marks, m)) ps 0.8 lc rgb "#80".word(colours, m)[2:7], \
         for [m=1:words(methods)] csv every ::1 using (place(strcol(2)) + 0.08 * (m - 5)):(of('culled', m, $9)) with points pt int(word(marks, m)) ps 1 lc rgb word(colours, m)
    set xtics auto
    unset logscale
    unset multiplot
    unset output
}
