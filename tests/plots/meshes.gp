# meshes.gp - from `enfilade bench meshes` (CSV, a row a building and mesh): error against elements, of even meshes, of even ones
# cut where things stand, and of adaptive ones. Of up to four buildings, in the order of the file.
# usage: gnuplot -e "csv='build/bench/meshes.csv'; out='build/pictures/meshes'" tests/plots/meshes.gp
# writes OUT.svg and OUT.png
set datafile separator ','
set datafile missing NaN
names = system(sprintf("tail -n +2 %s | cut -d, -f1 | uniq | head -4", csv))
# A row's figure where it is of this building and mesh, else nothing.
of(name, mesh, figure) = strcol(1) eq name && strcol(2) eq mesh ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,800 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,800 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 2,2
    set key outside bottom center horizontal maxcols 3 samplen 2
    set xlabel 'elements'
    set ylabel 'RMS, percent of the mean irradiance'
    do for [b=1:words(names)] {
        name = word(names, b)
        set title name noenhanced
        plot csv every ::1 using 4:(of(name, 'even', $8)) with linespoints pt 7 lw 2 lc rgb '#909090' title 'even, of elements', \
            csv every ::1 using 4:(of(name, 'cut', $8)) with linespoints pt 7 lw 2 lc rgb '#3060b0' title 'cut, of elements', \
            csv every ::1 using 4:(of(name, 'adaptive', $8)) with linespoints pt 7 lw 2 lc rgb '#b02020' title 'adaptive, of elements', \
            csv every ::1 using 4:(of(name, 'even', $9)) with linespoints pt 9 dt 2 lw 2 lc rgb '#909090' title 'even, between corners', \
            csv every ::1 using 4:(of(name, 'cut', $9)) with linespoints pt 9 dt 2 lw 2 lc rgb '#3060b0' title 'cut, between corners', \
            csv every ::1 using 4:(of(name, 'adaptive', $9)) with linespoints pt 9 dt 2 lw 2 lc rgb '#b02020' title 'adaptive, between corners'
    }
    unset multiplot
    unset output
}
