# SPDX-License-Identifier: Apache-2.0
# Mistakes caught against what a level costs, on three scenes.

name = "checks"
load script . "/style.gp"
set title "What a level catches, and what it costs"
set xlabel "CPU time added to a build, nanoseconds"
set ylabel "planted mistakes caught, percent"
set logscale x
set format x "%'.0f"
set decimalsign locale "C"
set format x "%.0f"
set yrange [0:110]
set key bottom right
ns(scene, by) = "ns, " . scene . ", " . by
plot folder . "/checks.csv" using (column(ns("1,000 small meshes", "device"))):"caught_percent" \
        with linespoints linewidth 2 pointtype 7 pointsize 1.2 linecolor rgb first_colour \
        title "one of 1,000 small meshes, by the device", \
    "" using (column(ns("1,000 small meshes", "device"))):(column("caught_percent") + 4):"level" \
        with labels font ",11" textcolor rgb first_colour notitle, \
    "" using (column(ns("one mesh", "device"))):"caught_percent" \
        with linespoints linewidth 2 pointtype 5 pointsize 1.2 linecolor rgb second_colour \
        title "a mesh of 70,000 triangles, by the device", \
    "" using (column(ns("100,000 instances", "device"))):"caught_percent" \
        with linespoints linewidth 2 pointtype 9 pointsize 1.4 linecolor rgb third_colour \
        title "100,000 instances, by the device", \
    "" using (column(ns("100,000 instances", "host"))):"caught_percent" \
        with linespoints linewidth 2 dashtype 2 pointtype 8 pointsize 1.4 \
        linecolor rgb third_colour title "100,000 instances, by the host"
