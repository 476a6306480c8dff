# walk.gp - from `enfilade bench walk` (CSV, a row a building and method): what each way of culling draws and costs. An occlusion culler
# of others (`--peer`) is a row more.
# usage: gnuplot -e "csv='build/bench/walk.csv'; out='tests/pictures/culling.png'" tests/plots/walk.gp
set terminal pngcairo size 1100,420 font 'DejaVu Sans,10' background '#ffffff'
set output out
set datafile separator ','
methods = "none frustum portals plan stab peer"
colours = "#b0b0b0 #7a5fa8 #d08020 #3080c0 #b02020 #408040"
titles = "'polygons drawn, % of all' 'query, microseconds' 'frame, ms (640x360, software OpenGL)'"
count = words(system(sprintf("cut -d, -f2 %s | sort -u | grep -v method | tr '\\n' ' '", csv)))
buildings = int(system(sprintf("grep -c ',none,' %s", csv)))
label_of(file) = file[1:strstrt(file, '.') - 1]
figure(k, drawn, all, query, frame) = k == 1 ? 100 * drawn / all : k == 2 ? query : frame
place(row) = int(row / count) * (count + 1.5) + int(row) % count
set boxwidth 0.9
set style fill solid
set grid ytics lc rgb '#dddddd'
set border 3
set tics nomirror
set xtics scale 0
set xrange [-1.5:buildings * (count + 1.5) - 0.5]
set logscale y
set yrange [*:*]
set key top right horizontal samplen 1
set multiplot layout 1,3
do for [k=1:3] {
    set title word(titles, k)
    if (k == 1) { set yrange [0.1:300] } else { set yrange [1:*] }
    plot for [m=0:count - 1] csv every ::1 using (int($0) % count == m ? place($0) : NaN):(figure(k, $5, $4, $7, $8)) with boxes lc rgb word(colours, m + 1) title (k == 1 ? word(methods, m + 1) : ''), csv every count::1 using ((count + 1.5) * $0 + count / 2.0 - 0.5):(1):xtic(label_of(stringcolumn(1))) with points ps 0 notitle
}
unset multiplot
