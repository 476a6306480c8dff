# rays.gp - from `enfilade bench rays` (CSV): what a ray costs in buildings by the hierarchy, the grid and Embree; and of Bezier patches
# by each method.
# usage: gnuplot -e "csv='build/bench/rays.csv'; out='build/pictures/rays'" tests/plots/rays.gp
# writes OUT.svg and OUT.png
set datafile separator ','
set datafile missing NaN
trees = "own grid embree"
methods = "clip clip-whole halve newton"
colours = "#202020 #80b060 #b0a0d0 #d08020"
buildings = "two-rooms.plan house.plan office.plan office-plain.plan"
patches = "flat saddle waves fold loop spike sphere torus vase edge weights trimmed"
kinds = "picture anywhere between"
# The place of a row on the axis, NaN where it is none of this panel's.
index(list, name) = int(sum [i=1:words(list)] (word(list, i) eq name ? i : 0))
building(row) = index(buildings, word(row, 1)) > 0 && words(row) == 2 ? index(buildings, word(row, 1)) + 0.27 * (index(kinds, word(row, 2)) - 2) : NaN
patch(row) = words(row) == 1 && index(patches, row) > 0 ? index(patches, row) : NaN
is(method, row, figure) = strcol(2) eq method ? figure : NaN
set grid ytics lc rgb '#dddddd'
set border 3
set tics nomirror
do for [format in "svg png"] {
    if (format eq "svg") { set terminal svg size 1200,460 font 'DejaVu Sans,11' background '#ffffff' }
    if (format eq "png") { set terminal pngcairo size 1200,460 font 'DejaVu Sans,10' background '#ffffff' }
    set output sprintf('%s.%s', out, format)
    set multiplot layout 1,2 margins 0.07,0.98,0.16,0.88 spacing 0.08,0.1
    set key above horizontal samplen 1
    set ylabel 'ns a ray, one thread'
    set yrange [0:*]
    set xrange [0.5:4.5]
    set xlabel 'of each: rays of a picture, anywhere, between two places'
    set xtics nomirror ("two-rooms" 1, "house" 2, "office" 3, "office-plain" 4)
    plot for [m=1:words(trees)] csv every ::1 using (building(strcol(1)) + 0.075 * (m - 2)):(is(word(trees, m), 0, $6)):(0.065) \
        with boxes fs solid 0.9 lc rgb word(colours, m) title word(trees, m)
    set logscale y
    set yrange [100:*]
    set xrange [0.5:words(patches) + 0.5]
    set xlabel 'Bezier patches: rays that hit'
    unset xtics
    set xtics nomirror rotate by 30 right
    do for [i=1:words(patches)] { set xtics add (word(patches, i) i) }
    plot for [m=1:words(methods)] csv every ::1 using (patch(strcol(1)) + 0.1 * (m - 2.5)):(is(word(methods, m), 0, $6)) \
        with points pt (m == 1 ? 7 : 2 * m + 1) lc rgb word(colours, m) title word(methods, m)
    unset logscale
    set xtics norotate
    unset multiplot
    unset output
}
