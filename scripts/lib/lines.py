#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints which share of the lines of src/ the tests have executed, by folder, and writes the lines
that they have not executed to BUILD/lines-missing.txt. Reads the counts that programs of preset
coverage leave in the build folder. Exit status 1 if the share is below --at-least."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
from collections import Counter, defaultdict

BATCH = 50  # objects that one gcov reads


def read_counts(root, build):
    """For each file of src/: how often each of its lines was executed."""
    notes = sorted(str(path) for path in build.rglob("*.gcno"))
    if not notes:
        sys.exit(f"{build}: no object was built for coverage")
    files = defaultdict(Counter)
    for first in range(0, len(notes), BATCH):
        run = subprocess.run(["gcov", "--json-format", "--stdout", *notes[first:first + BATCH]],
                             cwd=build, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                             check=True, text=True)
        for text in run.stdout.splitlines():
            add_counts(root, json.loads(text), files)
    return files


def add_counts(root, report, files):
    """Of a header, or of a source that several programs compile, the counts add up."""
    for entry in report["files"]:
        path = os.path.join(report["current_working_directory"], entry["file"])
        name = os.path.relpath(os.path.normpath(path), root)
        if name.startswith("src/"):
            for line in entry["lines"]:
                files[name][line["line_number"]] += line["count"]


def ranges(numbers):
    """[1, 2, 3, 7] as "1-3, 7"."""
    texts, first, last = [], None, None
    for number in [*sorted(numbers), None]:
        if first is not None and number != last + 1:
            texts.append(f"{first}-{last}" if first != last else f"{first}")
            first = None
        first, last = number if first is None else first, number
    return ", ".join(texts)


def write_missing(path, files):
    with path.open("w", encoding="utf-8") as output:
        for name, counts in sorted(files.items()):
            missing = [line for line, count in counts.items() if count == 0]
            if missing:
                output.write(f"{name}: {ranges(missing)}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path, help="of the repository")
    parser.add_argument("build", type=pathlib.Path, help="build folder of preset coverage")
    parser.add_argument("--at-least", type=float, default=95, metavar="PERCENT")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    files = read_counts(arguments.root.resolve(), build)
    if not files:
        sys.exit(f"{build}: no line of src/ is counted")
    folders, executed = Counter(), Counter()
    for name, counts in files.items():
        for folder in (os.path.dirname(name), "all"):
            folders[folder] += len(counts)
            executed[folder] += sum(count > 0 for count in counts.values())
    for folder in (*sorted(folders.keys() - {"all"}), "all"):
        share = 100 * executed[folder] / folders[folder]
        print(f"{folder:<24} {executed[folder]:>6} of {folders[folder]:>6} lines  {share:5.1f} %")
    write_missing(build / "lines-missing.txt", files)
    share = 100 * executed["all"] / folders["all"]
    print(f"line coverage of src/: {share:.2f} %, at least {arguments.at_least:g} % wanted; "
          f"lines that no test executes: {build / 'lines-missing.txt'}")
    return 0 if share >= arguments.at_least else 1


if __name__ == "__main__":
    sys.exit(main())
