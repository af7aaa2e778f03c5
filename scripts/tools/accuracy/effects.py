#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts, with callgrind, the instructions that a build takes from its recording to the end of its
submission: where an effect (updates, compaction, an extension ...) has never been seen, where it could
be used and isn't, and where it is; and those that the reference builder takes for a mesh and rays of
no effect, beside what it took before it knew any. Writes them as CSV, and fails where a scene pays for
a core effect that it doesn't use, or where a count is higher than expected."""

import argparse
import csv
import multiprocessing.pool
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from callgrind import collect  # noqa: E402

# The last three are extensions: their rules are asked once they are enabled.
CORE = ("update", "compaction", "instances", "indirect")
EXTENSIONS = ("motion", "micromap", "spheres")
USES = ("never", "unused", "used")
TIMES = 10
ACCURACIES = ("fast", "robust", "exact")
# Counted at the last revision whose builder knew nothing of motion, micromaps, spheres and dense
# geometry, with gcc 12.2.
PLAIN = pathlib.Path(__file__).parent / "plain.csv"
NOISE = 0.01   # hash tables and addresses differ
MARGIN = 0.15  # so do compilers and C libraries


def fail(message):
    sys.exit(f"effects.py: {message}")


def count(arguments, effect, use):
    """Instructions a build."""
    collected, printed = collect(arguments.valgrind, "counted_runs", arguments.program, effect,
                                 use, TIMES)
    return collected / int(re.search(r"(\d+) builds", printed)[1])


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


def count_plain(arguments):
    """What the reference builder takes now beside what the file says it took."""
    with open(PLAIN, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        function = "counted_build" if row["what"] == "build" else "counted_rays"
        accuracy = ACCURACIES.index(row["what"].split()[-1]) if function == "counted_rays" else 0
        row["now"] = collect(arguments.valgrind, function, arguments.plain, accuracy)[0]
    print(f"\n{'plain mesh':26}{'before':>12}{'now':>12}  instructions")
    for row in rows:
        print(f"{row['what']:26}{row['before']:>12}{row['now']:12}")
    if arguments.plain_csv:
        with open(arguments.plain_csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return [f"plain mesh, {row['what']}: {row['now']} instructions, before it knew any effect "
            f"{row['before']}" for row in rows if row["now"] > int(row["before"]) * (1 + MARGIN)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="accuracy_effects")
    parser.add_argument("--valgrind", default="valgrind")
    parser.add_argument("--only", metavar="EFFECT", choices=CORE + EXTENSIONS)
    parser.add_argument("--csv", type=pathlib.Path, metavar="FILE", help="write the counts there")
    parser.add_argument("--expected", type=pathlib.Path, metavar="FILE",
                        help="counts that must not be exceeded")
    parser.add_argument("--plain", type=pathlib.Path, metavar="PROGRAM", help="accuracy_plain")
    parser.add_argument("--plain-csv", type=pathlib.Path, metavar="FILE")
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
    if arguments.plain:
        wrong += count_plain(arguments)
    if wrong:
        fail("\n".join(wrong))


if __name__ == "__main__":
    main()
