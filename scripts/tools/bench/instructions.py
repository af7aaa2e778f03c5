#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts what the layer adds to recording a build: instructions, with callgrind, and system calls
that probe memory, which callgrind doesn't see. Compares both with the counts in a file, so that a
slow-down shows on a machine whose clock says little. With --conflicts all builds of a call have the
same dst and scratch, and a build of a large call takes no more than one of a small call: the search
for pairs stays linear, however many pairs are in conflict."""

import argparse
import csv
import pathlib
import sys
from collections import namedtuple

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from callgrind import count_recording  # noqa: E402

STRUCTURES, TIMES = 1000, 10

# Builds of STRUCTURES, in calls of so many builds.
Case = namedtuple("Case", "buffers order call")
CASES = [Case(buffers, order, call) for call in (STRUCTURES, 1)
         for buffers in ("shared", "separate") for order in ("created", "shuffled")]
MARGIN = 0.15  # compilers and C libraries differ,
PROBES_SLACK = 5  # and so do the pages that arrays begin in

# Builds a call whose builds are all in conflict; and the margin, of what the small call takes: its
# square would be eight times that.
SMALL, LARGE, CONFLICT_MARGIN = 1000, 8000, 0.5

# Instructions of a build, probes of a round of all.
Counts = namedtuple("Counts", "instructions probes")


def fail(message):
    sys.exit(f"instructions.py: {message}")


def count(arguments, case, layer, times, *options):
    """What recording takes with the layer ("on") or without ("off")."""
    instructions, probes = count_recording(
        arguments, layer, "--buffers", case.buffers, "--order", case.order, "--sizes", case.call,
        "--times", times, *options)
    return Counts(instructions, probes / times)


def compare_conflicts(arguments):
    added = {}
    for builds in (SMALL, LARGE):
        case = Case("shared", "created", builds)
        without, with_layer = (count(arguments, case, layer, 2, "--conflicts").instructions
                               for layer in ("off", "on"))
        added[builds] = with_layer - without
        print(f"{builds:5} builds a call: {added[builds]:.0f} instructions a build", flush=True)
    if added[LARGE] > added[SMALL] * (1 + CONFLICT_MARGIN):
        fail("a build of a large call takes more than one of a small call")


def read_expected(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            return {Case(row["buffers"], row["order"], int(row["call"])):
                    Counts(int(row["instructions"]), int(row["probes"]))
                    for row in csv.DictReader(file)}
    except (OSError, KeyError, ValueError) as error:
        fail(f"{path}: {error}")


def write_expected(path, added):
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow((*Case._fields, *Counts._fields))
        rows.writerows((*case, *map(round, counts)) for case, counts in added.items())


def is_more(counted, expected):
    return (counted.instructions > expected.instructions * (1 + MARGIN)
            or counted.probes > expected.probes * (1 + MARGIN) + PROBES_SLACK)


def verdict(counted, expected):
    if is_more(counted, expected):
        return "MORE"
    return "fewer: update the file" if is_more(expected, counted) else "as expected"


def compare_expected(arguments):
    expected = {} if arguments.update else read_expected(arguments.expected)
    added = {}
    worse = False
    print(f"Null driver, {STRUCTURES} structures: instructions a build, probes of memory a round\n")
    print(f"{'buffers':10}{'order':10}{'a call':>6}{'without':>9}{'with':>9}"
          f"{'overhead':>10}{'expected':>10}{'probes':>8}{'expected':>10}")
    without_layer = {}  # by the size of the call, the only thing that matters to the null driver
    for case in CASES:
        if case.call not in without_layer:
            without_layer[case.call] = count(arguments, case, "off", TIMES, "--alive", STRUCTURES)
        without = without_layer[case.call]
        with_layer = count(arguments, case, "on", TIMES, "--alive", STRUCTURES)
        added[case] = Counts(with_layer.instructions - without.instructions, with_layer.probes)
        wanted = added[case] if arguments.update else expected.get(case)
        if not wanted:
            fail(f"{arguments.expected} has no row for {', '.join(map(str, case))}")
        told = verdict(added[case], wanted)
        worse = worse or told == "MORE"
        print(f"{case.buffers:10}{case.order:10}{case.call:6}"
              f"{without.instructions:9.0f}{with_layer.instructions:9.0f}"
              f"{added[case].instructions:10.0f}{wanted.instructions:10.0f}"
              f"{added[case].probes:8.0f}{wanted.probes:10.0f}  {told}", flush=True)
    if arguments.update:
        write_expected(arguments.expected, added)
    if worse:
        fail(f"more than expected by over {MARGIN:.0%}; if that is meant, run "
             "scripts/bench instructions --update")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", type=pathlib.Path, required=True, help="the program")
    parser.add_argument("--valgrind", default="valgrind")
    parser.add_argument("--update", action="store_true", help="write the counts to the file")
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--expected", type=pathlib.Path, help="the file of counts")
    mode.add_argument("--conflicts", action="store_true")
    arguments = parser.parse_args()
    (compare_conflicts if arguments.conflicts else compare_expected)(arguments)


if __name__ == "__main__":
    main()
