# rooms.gp - from `enfilade bench rooms` (CSV, a row a building, method and culling): what a shot costs as a building grows,
# culled and not, in rooms whose doorways lie anywhere (rooms-N) and all in line (enfilade-N).
# usage: gnuplot -e "csv='build/bench/rooms.csv'; out='build/pictures/rooms'" tests/plots/rooms.gp
# writes OUT.svg and OUT.png
set datafile separator ','
cullings = "none depth cells plan stab"
titles = '"nothing culled" "by depth alone" "cell-to-cell" "stab tree in plan" "stab tree"'
colours = "#909090 #208040 #d08020 #3080c0 #b02020"
marks = "7 11 9 5 13"
# A row's figure where it is of the buildings and the culling, by the hemisphere; else nothing.
of(kind, culling, figure) = (strcol(1)[1:strlen(kind)] eq kind && strcol(6) eq 'hemisphere' && strcol(7) eq culling) ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set xrange [8:1300]
set xlabel 'rooms'
set datafile missing NaN
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,460 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,460 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,2
    set key top left samplen 2
    set ylabel 'ms a shot, hemisphere of 100'
    set title 'filled: doorways anywhere; dashed: all doorways in line'
    plot for [c=1:5] csv every ::1 using 2:(of('rooms', word(cullings, c), $9)) with linespoints pt int(word(marks, c)) lw 2 lc rgb word(colours, c) title word(titles, c), \
         for [c=1:5] csv every ::1 using 2:(of('enfilade', word(cullings, c), $9)) with linespoints pt int(word(marks, c)) ps 0.6 dt 2 lc rgb word(colours, c) notitle
    unset key
    set title ' '
    set ylabel 'polygons looked at'
    plot for [c=1:5] csv every ::1 using 2:(of('rooms', word(cullings, c), $11)) with linespoints pt int(word(marks, c)) lw 2 lc rgb word(colours, c), \
         for [c=1:5] csv every ::1 using 2:(of('enfilade', word(cullings, c), $11)) with linespoints pt int(word(marks, c)) ps 0.6 dt 2 lc rgb word(colours, c)
    unset multiplot
    unset output
}
