# radiosity.gp - from `enfilade bench radiosity` (CSV): the papers' tables as ratios, theirs beside ours.
# usage: gnuplot -e "csv='build/bench/radiosity.csv'; out='build/pictures/radiosity'" tests/plots/radiosity.gp
# writes OUT.svg and OUT.png
set datafile separator ','
# Of the rows of one table and building: what column holds for a method and culling.
get(table, building, method, culling, column) = real(system(sprintf("awk -F, '$1 == \"%s\" && $2 == \"%s\" && $3 == \"%s\" && $4 == \"%s\" { print $%d }' %s", table, building, method, culling, column, csv)))
hemi(table, kind) = get(table, 'room', 'hemicube' . kind, 'none', 11) / get(table, 'room', 'hemisphere' . kind, 'none', 11)
oki(building, column) = get('oki', building, 'hemicube-elements', 'none', column) / get('oki', building, 'hemicube-elements', 'plan', column)
array theirs[5] = [76612.0 / 23695, 7332.0 / 3332, NaN, 21.6 / 6.7, 351.4 / 135.9]
array drawn[5] = [oki('office.plan', 10), oki('office.plan', 11), oki('office-plain.plan', 11), hemi('doi-itoh-1', '-elements'), hemi('doi-itoh-2', '-elements')]
array today[5] = [NaN, NaN, NaN, hemi('doi-itoh-1', ''), hemi('doi-itoh-2', '')]
set style fill solid
set boxwidth 0.25
set grid y lc rgb '#dddddd'
set border 3
set tics nomirror
set logscale y
set yrange [0.5:*]
set ylabel 'ratio'
set key top right
set xtics ("Oki: elements drawn" 1, "Oki: time" 2, "Oki: time, office-plain" 3, "Doi and Itoh, 548 elements" 4, "3,294 elements" 5)
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 900,420 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 900,420 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    plot [0.4:5.6] '+' using (int($0) < 5 ? int($0) + 1 - 0.27 : NaN):(int($0) < 5 ? theirs[int($0) + 1] : NaN) with boxes lc rgb '#909090' title 'as printed', \
         '+' using (int($0) < 5 ? int($0) + 1.0 : NaN):(int($0) < 5 ? drawn[int($0) + 1] : NaN) with boxes lc rgb '#3080c0' title 'elements drawn, as they did', \
         '+' using (int($0) < 5 ? int($0) + 1.27 : NaN):(int($0) < 5 ? today[int($0) + 1] : NaN) with boxes lc rgb '#b02020' title 'faces drawn, exact directions'
    unset output
}
