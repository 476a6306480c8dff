# walk.gp - from `enfilade bench walk` (CSV, five methods a building): what each way of culling draws and costs.
# usage: gnuplot -e "csv='build/bench/walk.csv'; out='tests/pictures/culling.png'" tests/plots/walk.gp
set terminal pngcairo size 1100,420 font 'DejaVu Sans,10' background '#ffffff'
set output out
set datafile separator ','
methods = "none frustum portals plan stab"
colours = "#b0b0b0 #7a5fa8 #d08020 #3080c0 #b02020"
titles = "'polygons drawn, % of all' 'query, microseconds' 'frame, ms (640x360, software OpenGL)'"
place(row) = int(row / 5) * 6.5 + int(row) % 5
label_of(file) = file[1:strlen(file) - 5]
figure(k, drawn, all, query, frame) = k == 1 ? 100 * drawn / all : k == 2 ? query : frame
set boxwidth 0.9
set style fill solid
set grid ytics lc rgb '#dddddd'
set border 3
set tics nomirror
set xtics scale 0
set xrange [-1.5:25.5]
set logscale y
set yrange [1:300]
set key top right horizontal samplen 1
set multiplot layout 1,3
do for [k=1:3] {
    set title word(titles, k)
    plot for [m=0:4] csv every ::1 using (int($0) % 5 == m ? place($0) : NaN):(figure(k, $5, $4, $7, $8)) with boxes lc rgb word(colours, m + 1) title (k == 1 ? word(methods, m + 1) : ''), csv every 5::3 using (6.5 * $0 + 2):(1):xtic(label_of(stringcolumn(1))) with points ps 0 notitle
}
unset multiplot
