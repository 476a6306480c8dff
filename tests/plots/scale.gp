# scale.gp - from `enfilade bench scale` (CSV, a row a building and stage): how time and memory of each stage grow with rooms, on
# logarithmic axes, with the slope of the line that fits best; and the bytes that the first of two and of four processes sends.
# usage: gnuplot -e "csv='build/bench/scale.csv'; out='build/pictures/scale'" tests/plots/scale.gp
# writes OUT.svg and OUT.png
set datafile separator ','
stages = "reading cells pairs trees query mesh shooting shown parts"
colours = "#909090 #208040 #d08020 #3080c0 #b02020 #7040a0 #a06040 #c060a0 #202020"
marks = "7 11 9 5 13 4 6 8 10"
of(stage, figure) = strcol(2) eq stage && figure > 0 ? figure : NaN
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale xy
set format y '10^{%L}'
set xlabel 'rooms'
set datafile missing NaN
array time[words(stages)]
array memory[words(stages)]
do for [s=1:words(stages)] {
    stats csv every ::1 using (log($1)):(log(of(word(stages, s), $3))) name 'T' nooutput
    stats csv every ::1 using (log($1)):(log(of(word(stages, s), $4))) name 'M' nooutput
    time[s] = T_slope
    memory[s] = M_slope
}
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1900,460 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1900,460 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,3
    set key outside right top samplen 2
    set ylabel 'seconds, one thread; of a query'
    plot for [s=1:words(stages)] csv every ::1 using 1:(of(word(stages, s), $3)) with linespoints pt int(word(marks, s)) lw 2 lc rgb word(colours, s) title sprintf('%s: slope %.2f', word(stages, s), time[s])
    set ylabel 'MB at most, without libraries'
    plot for [s=1:words(stages)] csv every ::1 using 1:(of(word(stages, s), $4)) with linespoints pt int(word(marks, s)) lw 2 lc rgb word(colours, s) title sprintf('%s: slope %.2f', word(stages, s), memory[s])
    set ylabel 'bytes from the first process to others'
    plot for [n in "2 4"] csv every ::1 using 1:(of('sent-of-'.n, $5)) with linespoints pt int(n) lw 2 lc rgb word(colours, int(n)) title n.' processes'
    unset multiplot
    unset output
}
