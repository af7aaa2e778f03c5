# SPDX-License-Identifier: Apache-2.0
# Mistakes caught against what a level costs, on three scenes.

name = "checks"
load script . "/style.gp"
set title "What a level catches, and what it costs"
set xlabel "CPU time added to a build"
set ylabel "planted mistakes caught, percent"
set logscale x
set format x "%.0s %cs"
seconds(name) = column(name) * 1e-9
set yrange [0:110]
set xrange [3e-8:3e-1]
# Levels that catch nearly the same are told above and below.
label_y(percent) = percent > 99 || percent < 90 ? percent + 4 : percent - 4
set key bottom right
plot folder . "/checks.csv" using (seconds("device_small_ns")):"caught_percent" \
        with linespoints linewidth 2 pointtype 7 pointsize 1.2 linecolor rgb first_colour \
        title "one of 1,000 small meshes, by the device", \
    "" using (seconds("device_small_ns")):(label_y(column("caught_percent"))):"level" \
        with labels font ",11" textcolor rgb first_colour notitle, \
    "" using (seconds("device_mesh_ns")):"caught_percent" \
        with linespoints linewidth 2 pointtype 5 pointsize 1.2 linecolor rgb second_colour \
        title "a mesh of 70,000 triangles, by the device", \
    "" using (seconds("device_instances_ns")):"caught_percent" \
        with linespoints linewidth 2 pointtype 9 pointsize 1.4 linecolor rgb third_colour \
        title "100,000 instances, by the device", \
    "" using (seconds("host_instances_ns")):"caught_percent" \
        with linespoints linewidth 2 dashtype 2 pointtype 8 pointsize 1.4 \
        linecolor rgb third_colour title "100,000 instances, by the host"
