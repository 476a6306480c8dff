# formfactors.gp - from `enfilade bench formfactors` of one building (CSV, a row a method, culling and resolution): what one
# shot costs against its error, a line a method and culling; heavy, the runs that no other beats at both (Pareto front).
# usage: gnuplot -e "csv='build/bench/formfactors.csv'; out='build/pictures/formfactors'" tests/plots/formfactors.gp
# writes OUT.svg and OUT.png
set datafile separator ','
methods = "hemisphere hemicube hemisphere-scanline hemisphere-scanlines hemisphere-scanlines-fit hemisphere-polyline analytic ray ray-disc ray-hemicube hemicube-raycast hemicube-osmesa"
colours = "#3080c0 #d08020 #208040 #80b060 #c0a000 #b02020 #202020 #7a5fa8 #b0a0d0 #909090 #c08080 #60a0a0"
marks = "7 5 9 11 2 13 15 6 10 4 1 3"
# A row's figure where it is of this method and culling, else nothing.
of(m, culling, figure) = strcol(2) eq word(methods, m) && strcol(4) eq culling ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set xlabel 'milliseconds a shot, one core, the look at what is in view included'
set ylabel 'L1 of the row against random rays'
set yrange [0.005:0.3]
set key outside right top samplen 2
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1000,560 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1000,560 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    plot csv every ::1 using ($14 == 1 ? $6 : NaN):8 smooth unique with lines lw 6 lc rgb '#f0d890' title 'Pareto front', \
        for [m=1:7] csv every ::1 using (of(m, 'stab', $6)):8 with linespoints pt int(word(marks, m)) ps 1 lc rgb word(colours, m) title word(methods, m), \
        for [m=1:2] csv every ::1 using (of(m, 'depth', $6)):8 with linespoints dt 3 pt int(word(marks, m)) ps 0.7 lc rgb word(colours, m) title word(methods, m).', by depth alone', \
        for [m=1:words(methods)] csv every ::1 using (of(m, 'none', $6)):8 with linespoints dt 2 pt int(word(marks, m)) ps 0.7 lc rgb word(colours, m) title (m < 8 ? word(methods, m).', not culled' : word(methods, m))
    unset output
}
