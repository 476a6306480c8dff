# visibility.gp - from `enfilade bench visibility` (CSV, a row a building and method): what each method costs against what
# it shows too much, a point a building; and how its cost grows with the number of cells.
# usage: gnuplot -e "csv='build/bench/visibility.csv'; out='build/pictures/visibility'" tests/plots/visibility.gp
# writes OUT.svg and OUT.png
set datafile separator ','
set datafile missing 'skipped'
methods = "flood plan height flow proof peer"
colours = "#909090 #7a5fa8 #d08020 #3080c0 #b02020 #208040"
marks = "7 9 5 11 13 3"
# An over-estimate of nothing has no place on a logarithmic scale: it stands at the bottom.
least = 0.001
over(x) = x < least ? least : x
# A row's figure where it is of method m, else nothing.
of(m, figure) = strcol(2) eq word(methods, m) ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set style data points
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,460 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,460 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,2
    set key above horizontal samplen 1
    set xlabel 'CPU seconds, one thread'
    set ylabel 'visible pairs above the proven ones, %'
    set yrange [least * 0.7:*]
    set ytics add ('none' least)
    plot for [m=1:words(methods)] csv every ::1 using (of(m, $5)):(of(m, over($13))) pt int(word(marks, m)) ps 1.2 lc rgb word(colours, m) title word(methods, m)
    unset key
    set ytics auto
    set xlabel 'cells'
    set ylabel 'CPU seconds, one thread'
    set yrange [*:*]
    plot for [m=1:words(methods)] csv every ::1 using (of(m, $3)):(of(m, $5)) pt int(word(marks, m)) ps 1.2 lc rgb word(colours, m)
    unset multiplot
    unset output
}
