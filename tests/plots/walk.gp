# walk.gp - from `enfilade bench walk` (CSV): what each way of culling draws, and what it costs to know.
# usage: gnuplot -e "csv='build/bench/walk.csv'; out='tests/pictures/culling.png'" tests/plots/walk.gp
set terminal pngcairo size 1100,480 font 'DejaVu Sans,10' background '#ffffff'
set output out
set datafile separator ','
set key autotitle columnhead
set logscale xy
set grid lc rgb '#dddddd'
set xlabel 'query, microseconds a frame (mean)'
set ylabel 'polygons drawn, % of all (mean)'
set yrange [0.5:150]
set key outside right top
buildings = "two-rooms.plan house.plan office.plan office-plain.plan"
methods = "none frustum portals plan stab"
colours = "#999999 #7a5fa8 #d08020 #3080c0 #b02020"
set multiplot layout 1,2
set title 'all methods'
unset key
plot for [m=1:5] csv using (strcol(2) eq word(methods,m) ? ($7 > 0.05 ? $7 : 0.05) : NaN):(100*$5/$4) \
    with points pt 7 ps 1.3 lc rgb word(colours,m) title word(methods,m), \
    for [m=1:5] csv using (strcol(2) eq word(methods,m) ? ($7 > 0.05 ? $7 : 0.05) : NaN):(100*$5/$4):1 \
    with labels offset 0,0.8 font ',7' tc rgb '#555555' notitle
set title 'frame time (640x360, software OpenGL)'
set key inside left top
set xlabel 'polygons drawn (mean)'
set ylabel 'frame, milliseconds (mean)'
set yrange [*:*]
plot for [m=1:5] csv using (strcol(2) eq word(methods,m) ? $5 : NaN):8 \
    with points pt 7 ps 1.3 lc rgb word(colours,m) title word(methods,m)
unset multiplot
