#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions, with callgrind, that the layer adds to recording calls whose builds all
have the same dst and scratch. A build of a large call takes no more than one of a small call: the
search for pairs stays linear, however many pairs are in conflict."""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from callgrind import count_recording  # noqa: E402

SMALL, LARGE = 1000, 8000  # builds a call
TIMES = 2
MARGIN = 0.5  # of what the small call takes; its square would be eight times that


def count(arguments, builds, layer):
    """Instructions a build, with the layer ("on") or without ("off")."""
    return count_recording(arguments, layer, "--buffers", "shared", "--order", "created",
                           "--sizes", builds, "--times", TIMES, "--conflicts")[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", type=pathlib.Path, required=True, help="the program")
    parser.add_argument("--valgrind", default="valgrind")
    arguments = parser.parse_args()
    added = {}
    for builds in (SMALL, LARGE):
        added[builds] = count(arguments, builds, "on") - count(arguments, builds, "off")
        print(f"{builds:5} builds a call: {added[builds]:.0f} instructions a build", flush=True)
    if added[LARGE] > added[SMALL] * (1 + MARGIN):
        sys.exit("conflicts.py: a build of a large call takes more than one of a small call")


if __name__ == "__main__":
    main()
