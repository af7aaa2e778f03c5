# SPDX-License-Identifier: Apache-2.0
# Instructions of a build without an effect and with it.

name = "effects"
load script . "/style.gp"
set title "Effects: a build pays for what it uses"
set ylabel "instructions a build, from recording to submission"
set style data histogram
set style histogram clustered gap 1
set style fill solid 0.9 border rgb "white"
set yrange [0:*]
set key top left
plot folder . "/effects.csv" using "never":xtic(1) linecolor rgb first_colour \
        title "without it, never seen", \
    "" using "unused" linecolor rgb fourth_colour title "without it, though it could be used", \
    "" using "used" linecolor rgb second_colour title "with it"
