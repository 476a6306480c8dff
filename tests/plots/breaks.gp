# breaks.gp - from `enfilade bench breaks` (CSV, a row a break, method and place): where each form-factor method breaks.
# usage: gnuplot -e "csv='build/bench/breaks.csv'; out='build/pictures/breaks'" tests/plots/breaks.gp
# writes OUT.svg and OUT.png
set datafile separator ','
methods = "hemisphere hemicube hemisphere-scanline hemisphere-scanlines hemisphere-scanlines-fit hemisphere-polyline analytic ray ray-disc ray-hemicube"
colours = "#3080c0 #d08020 #208040 #80b060 #c0a000 #b02020 #202020 #7a5fa8 #b0a0d0 #909090"
marks = "7 5 9 8 2 11 13 6 10 4"
# An error of nothing has no place on a logarithmic scale: it stands at the bottom.
least = 1e-9
shown(x) = x < least ? least : x
# A row's figure where it is of this break and method, else nothing.
of(name, m, figure) = strcol(1) eq name && strcol(2) eq word(methods, m) ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set format y '10^{%L}'
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1100,860 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1100,860 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 2,2 margins 0.08,0.98,0.08,0.87 spacing 0.1,0.12
    do for [panel=1:4] {
        name = word("pixels wall threshold origin", panel)
        if (panel == 1) { set xlabel 'side of a square, pixels (resolution 100)'; set ylabel 'relative error, RMS' }
        if (panel == 2) { set xlabel 'distance of a 1 x 1 m wall, metres (resolution 200)'; set ylabel 'error, RMS' }
        if (panel == 3) { set xlabel 'edges cut to, degrees (resolution 200)'; set ylabel 'relative error, RMS' }
        if (panel == 4) { set xlabel 'distance from the origin, metres'; set ylabel 'L1 to the row at the origin, RMS' }
        if (panel == 1) { set xrange [0.2:20] }
        if (panel == 2) { set xrange [8e-4:1.3] }
        if (panel == 3) { set xrange [0.4:220] }
        if (panel == 4) { set xrange [0.7:2e12] }
        if (panel == 4) { set format x '10^{%L}' } else { set format x '%g' }
        set yrange [least * 0.5:(panel == 1 ? 10 : panel == 4 ? 3 : 1)]
        set ytics add ('none' least)
        if (panel == 1) { set key at screen 0.5,0.985 center top horizontal maxrows 5 width -6 samplen 2 } else { unset key }
        plot for [m=1:words(methods)] csv every ::1 using 4:(of(name, m, shown($5))) with linespoints pt int(word(marks, m)) ps 0.9 lc rgb word(colours, m) title word(methods, m)
        set ytics auto
    }
    unset multiplot
    unset output
}
