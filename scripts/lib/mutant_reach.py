# SPDX-License-Identifier: Apache-2.0
"""Which tests execute which lines, counted by gcov. scripts/mutants runs only the tests that execute
the line of a mutation: it takes no effect in the others."""
import json
import os
import subprocess
from collections import defaultdict

BATCH = 50  # objects that one gcov reads


class Reach:
    """For each line: the tests that execute it, and the objects that have it. Of an inline function in
    a header these are several."""

    def __init__(self):
        self.tests = defaultdict(lambda: defaultdict(set))  # by file and line
        self.objects = defaultdict(lambda: defaultdict(set))
        self.seconds = {}  # that each test takes while it is counted

    def add(self, tree, build, test):
        """Reads and removes the counts that the programs of one test have left."""
        counts = sorted(str(path) for path in build.rglob("*.gcda"))
        for first in range(0, len(counts), BATCH):
            run = subprocess.run(["gcov", "--json-format", "--stdout", *counts[first:first + BATCH]],
                                 cwd=build, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                 check=True, text=True)
            for text in run.stdout.splitlines():
                self.add_report(tree, build, test, json.loads(text))
        for path in counts:
            os.remove(path)

    def add_report(self, tree, build, test, report):
        made = os.path.relpath(os.path.join(build, report["data_file"]), build)
        made = made.removesuffix(".gcda").removesuffix(".gcno") + ".o"
        for entry in report["files"]:
            path = os.path.join(report["current_working_directory"], entry["file"])
            name = os.path.relpath(os.path.normpath(path), tree)
            if name.startswith(("src/", "layer/")):
                for line in entry["lines"]:
                    number = line["line_number"]
                    self.objects[name][number].add(made)
                    self.tests[name][number].update([test] if line["count"] else [])

    def find(self, path, line):
        """The tests and the objects. Of a line without code of its own, such as the second one of a
        call, those of the lines before and after it that have some."""
        lines = self.tests.get(path, {})
        if line in lines:
            near = [line]
        else:
            near = [*sorted(number for number in lines if number < line)[-1:],
                    *sorted(number for number in lines if number > line)[:1]]
        return tuple(set().union(*(of[path][number] for number in near))
                     for of in (self.tests, self.objects))

    # ---- kept between runs

    def write(self, path):
        data = [{name: {line: sorted(names) for line, names in lines.items()}
                 for name, lines in of.items()} for of in (self.tests, self.objects)]
        path.write_text(json.dumps([*data, self.seconds]))

    def read(self, path):
        *both, self.seconds = json.loads(path.read_text())
        for of, data in zip((self.tests, self.objects), both):
            for name, lines in data.items():
                for line, names in lines.items():
                    of[name][int(line)] = set(names)
