#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts, with callgrind, the instructions that a build takes from its recording to the end of its
submission: where an effect (updates, compaction, an extension ...) has never been seen, where it could
be used and isn't, and where it is. Writes them as CSV, and fails where a scene pays for a core effect
that it doesn't use, or where a count is higher than expected."""

import argparse
import csv
import multiprocessing.pool
import pathlib
import re
import subprocess
import sys

# The last three are extensions: their rules are asked once they are enabled.
CORE = ("update", "compaction", "instances", "indirect")
EXTENSIONS = ("motion", "micromap", "spheres")
USES = ("never", "unused", "used")
TIMES = 10
NOISE = 0.01   # hash tables and addresses differ
MARGIN = 0.15  # so do compilers and C libraries


def fail(message):
    sys.exit(f"effects.py: {message}")


def count(arguments, effect, use):
    """Instructions a build."""
    run = subprocess.run(
        [arguments.valgrind, "--tool=callgrind", "--callgrind-out-file=/dev/null",
         "--collect-atstart=no", "--toggle-collect=counted_runs",
         arguments.program, effect, use, str(TIMES)], capture_output=True, text=True)
    collected = re.search(r"Collected : (\d+)", run.stderr)
    builds = re.search(r"(\d+) builds", run.stdout)
    if run.returncode or not collected or not builds or not int(collected[1]):
        fail(f"{effect}, {use}: the count failed ({run.returncode}):\n{run.stdout}{run.stderr}")
    return int(collected[1]) / int(builds[1])


def count_all(arguments, effects):
    pairs = [(effect, use) for effect in effects for use in USES]
    with multiprocessing.pool.ThreadPool(2) as pool:
        counts = pool.map(lambda pair: count(arguments, *pair), pairs)
    return {pair: round(counted) for pair, counted in zip(pairs, counts)}


def write(path, effects, counts):
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("effect", "kind", *USES))
        for effect in effects:
            kind = "core" if effect in CORE else "extension"
            rows.writerow((effect, kind, *(counts[effect, use] for use in USES)))


def compare(path, effects, counts):
    """What is more than the file says."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            expected = {(row["effect"], use): int(row[use])
                        for row in csv.DictReader(file) for use in USES}
        return [f"{effect}, {use}: {counts[effect, use]} instructions a build, expected "
                f"{expected[effect, use]}"
                for effect in effects for use in USES
                if counts[effect, use] > expected[effect, use] * (1 + MARGIN)]
    except (OSError, KeyError, ValueError) as error:
        return fail(f"{path}: {error}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="accuracy_effects")
    parser.add_argument("--valgrind", default="valgrind")
    parser.add_argument("--only", metavar="EFFECT", choices=CORE + EXTENSIONS)
    parser.add_argument("--csv", type=pathlib.Path, metavar="FILE", help="write the counts there")
    parser.add_argument("--expected", type=pathlib.Path, metavar="FILE",
                        help="counts that must not be exceeded")
    arguments = parser.parse_args()

    effects = (arguments.only,) if arguments.only else CORE + EXTENSIONS
    counts = count_all(arguments, effects)
    print(f"{'effect':12}" + "".join(f"{use:>9}" for use in USES) + "  instructions a build")
    for effect in effects:
        print(f"{effect:12}" + "".join(f"{counts[effect, use]:9}" for use in USES))
    if arguments.csv:
        write(arguments.csv, effects, counts)

    wrong = [f"{effect}: a scene without it pays {counts[effect, 'unused']} instructions a build "
             f"instead of {counts[effect, 'never']}"
             for effect in effects if effect in CORE
             and abs(counts[effect, "unused"] / counts[effect, "never"] - 1) > NOISE]
    if arguments.expected:
        wrong += compare(arguments.expected, effects, counts)
    if wrong:
        fail("\n".join(wrong))


if __name__ == "__main__":
    main()
