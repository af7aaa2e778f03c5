# SPDX-License-Identifier: Apache-2.0
# What the pictures share. Called with `folder` and `name` set.

set datafile separator ","
set datafile missing NaN
set encoding utf8
width = exists("width") ? width : 900
height = exists("height") ? height : 560
set terminal svg size width, height font "DejaVu Sans,13" background "white"
set output folder . "/" . name . ".svg"
set grid back linecolor rgb "#dddddd"
set border linecolor rgb "#444444"
set key noenhanced
# Colours that tell apart without red and green.
first_colour = "#0072b2"
second_colour = "#e69f00"
third_colour = "#cc3311"
fourth_colour = "#009e73"
