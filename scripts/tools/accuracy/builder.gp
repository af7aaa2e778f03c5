# SPDX-License-Identifier: Apache-2.0
# Builds against what their trees are worth: three meshes, SAH cost above, rays below.

name = "builder"
width = 1050
height = 680
load script . "/style.gp"
file = folder . "/builder.csv"
set multiplot layout 2,3 title "Builder: what a quality costs, and what its tree is worth (one thread)"
set logscale x
set xrange [0.2:40]
set xtics (0.3, 1, 3, 10, 30)
set offsets graph 0, graph 0, graph 0.15, graph 0.15
set xlabel "million primitives a second"
panels = '"bunny" "terrain" "soup"'
figure(row) = row == 1 ? "sah" : "ns_a_ray"
do for [row = 1:2] {
    do for [mesh in panels] {
        set title row == 1 ? mesh : ""
        set ylabel row == 1 ? "SAH cost" : "nanoseconds a ray"
        if (row == 1 && mesh eq "bunny") { set key top left } else { unset key }
        plot for [i = 1:2] builder = (i == 1 ? "Assay" : "Embree") file using \
                (strcol("mesh") eq mesh && strcol("builder") eq builder \
                    ? column("mprims_a_second") : NaN):(column(figure(row))) \
                with points pointtype (i == 1 ? 7 : 5) pointsize 1.3 \
                linecolor rgb (i == 1 ? first_colour : second_colour) title builder, \
            for [i = 1:2] builder = (i == 1 ? "Assay" : "Embree") file using \
                (strcol("mesh") eq mesh && strcol("builder") eq builder \
                    ? column("mprims_a_second") : NaN):(column(figure(row))):(strcol("quality")) \
                with labels offset 0,(i == 1 ? -0.9 : 0.9) font ",10" notitle
    }
}
unset multiplot
