# SPDX-License-Identifier: Apache-2.0
# Wrong answers against time, a panel for each set of rays; the front is joined.

name = "rays"
width = 1050
height = 680
load script . "/style.gp"
accuracies = "fast robust exact"
colour(i) = i == 1 ? first_colour : i == 2 ? second_colour : third_colour
file = folder . "/rays.csv"
set multiplot layout 2,3 title "Rays: wrong answers against time (ringed and joined: nothing is better in both)"
set logscale xy
set yrange [0.4:3e6]
set ytics ("none" 0.5, "1" 1, "100" 100, "10,000" 1e4, "1,000,000" 1e6)
set xrange [200:5e3]
set xtics (200, 500, "1,000" 1000, "2,000" 2000, "5,000" 5000)
set xlabel "nanoseconds a ray"
set ylabel "wrong in a million"
shown(y) = y < 0.5 ? 0.5 : y
do for [panel in '"random" "edges" "vertices" "grazing" "far origin" "subnormal"'] {
    set title panel
    if (panel eq "random") { set key top right } else { unset key }
    plot for [i = 1:3] file using \
            (strcol("rays") eq panel && strcol("accuracy") eq word(accuracies, i) \
                ? column("ns_a_ray") : NaN):(shown(column("wrong_in_a_million"))) \
            with points pointtype 7 pointsize 1.1 linecolor rgb colour(i) \
            title word(accuracies, i), \
        file using (strcol("rays") eq panel && column("front") == 1 ? column("ns_a_ray") : NaN): \
            (shown(column("wrong_in_a_million"))) smooth unique with lines linewidth 1.5 \
            linecolor rgb "#888888" notitle, \
        file using (strcol("rays") eq panel && column("front") == 1 ? column("ns_a_ray") : NaN): \
            (shown(column("wrong_in_a_million"))) with points pointtype 6 pointsize 2 linewidth 1.5 \
            linecolor rgb "#444444" notitle
}
unset multiplot
