# SPDX-License-Identifier: Apache-2.0
"""The programs of docs/capture.md, with the system's Python, which has NumPy's package.

usage: documented_test.py ASSAY_SCENE

Exits with 77 (skipped) without NumPy."""

import pathlib
import re
import subprocess
import sys
import unittest

from captures import Capture, Case, scene

PAGE = pathlib.Path(__file__).resolve().parent.parent.parent / "docs/capture.md"
PROGRAMS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def find_python():
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import numpy"], check=False, stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


class Programs(Case):
    def run_program(self, number, capture):
        capture.write()
        return subprocess.run([find_python(), "-c", PROGRAMS[number], self.folder], check=True, encoding="utf-8",
                              stdout=subprocess.PIPE).stdout

    def test_arrays(self):
        text = self.run_program(0, scene(self.folder))
        self.assertIn("1 vertices (4, 3) float32\n1 indices (6,) uint16\n1 transform (1, 3, 4) float32\n", text)
        self.assertIn("7 instances (5,) ('transform', 'customIndexAndMask', 'offsetAndFlags', 'reference')\n", text)

    def test_sizes_of_triangles(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 4, 0)], [0, 1, 2, 2, 1, 0, 0, 1, 3]))
        lines = self.run_program(1, capture).splitlines()
        self.assertEqual((len(lines), lines[0], lines[-1]), (10, f"{2:10} " + "#" * 60, f"{3.8:10} " + "#" * 30))

    def test_updates(self):
        capture = Capture(self.folder)
        for number, updates in ((1, 1), (2, 3)):
            capture.structure(number, name=f"number {number}")
            for _ in range(updates):
                capture.build(number, mode="update")
        self.assertEqual(self.run_program(2, capture), "number 2: 3 updates\n")


if __name__ == "__main__":
    if not find_python():
        print("skipped: NumPy is not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
