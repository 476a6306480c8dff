# pictures.gp - from `enfilade bench pictures` (CSV, a row a building, view, hour and method): how right the light is that a walk shows,
# against the seconds of its bake. On the left the mean error of the pixels, on the right their blotches; a point a view.
# usage: gnuplot -e "csv='build/bench/pictures.csv'; out='build/pictures/pictures'" tests/plots/pictures.gp
# writes OUT.svg and OUT.png
set datafile separator ','
buildings = system(sprintf("awk -F, 'NR > 1 && !seen[$1]++ { printf \"%%s \", $1 }' %s", csv))
methods = system(sprintf("awk -F, 'NR > 1 && !seen[$4]++ { printf \"%%s \", $4 }' %s", csv))
colours = "#b02020 #3080c0 #208040 #d08020 #7a5fa8 #20a0a0 #909090"
marks = "7 5 9 11 13 15"
# A row's figure where it is of the building and the method, else nothing.
of(building, method, figure) = (strcol(1) eq word(buildings, building) && strcol(4) eq word(methods, method)) ? figure : NaN
colour(building) = word(colours, (building - 1) % words(colours) + 1)
mark(method) = int(word(marks, (method - 1) % words(marks) + 1))
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set xlabel 'seconds of the bake'
set datafile missing NaN
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,460 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,460 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,2
    set key outside below noenhanced
    set ylabel 'mean error of pixels, percent'
    plot for [b=1:words(buildings)] for [m=1:words(methods)] csv every ::1 using 5:(of(b, m, 100 * $6)) with points pt mark(m) ps 1.2 lc rgb colour(b) title word(buildings, b).' '.word(methods, m)
    set ylabel 'blotches in the worst octave, percent'
    plot for [b=1:words(buildings)] for [m=1:words(methods)] csv every ::1 using 5:(of(b, m, 100 * $8)) with points pt mark(m) ps 1.2 lc rgb colour(b) title word(buildings, b).' '.word(methods, m)
    unset multiplot
    unset output
}
