# SPDX-License-Identifier: Apache-2.0
"""Writing a capture, or a part of it, from memory; and reading damaged captures.

usage: write_test.py SCENE_REWRITE Write
       write_test.py SCENE_FUZZ Fuzz COUNT"""

import json
import subprocess
import sys
import unittest

from captures import Case, npy, scene, struct


class Write(Case):
    def setUp(self):
        super().setUp()
        self.old, self.new = self.folder, self.place / "new"
        self.capture = scene(self.old)
        self.capture.finding(1, "pInfos[0].pGeometries[0]", "primitive 1")
        self.capture.add("Novelty", list=[1, {"a": None}])
        for line in self.capture.lines:
            if line["Type"] == "Build":
                line["scratch"] = {"address": "0x10", "buffer": 1, "offset": 16, "novelty": "é"}
                line["novelty"] = 1.5
                line["geometry"][0]["novelty"] = []
                line["geometry"][0]["inputs"][0]["novelty"] = -1
        self.capture.add("End", why="the device was destroyed")
        self.capture.write()

    def rewrite(self, *edits, status=0):
        process = subprocess.run([sys.argv[1], self.old, self.new, *map(str, edits)], check=False,
                                 stdout=subprocess.PIPE, encoding="utf-8")
        self.assertEqual(process.returncode, status, process.stdout)
        return process.stdout

    def lines(self):
        return [json.loads(line) for line in (self.new / "builds.jsonl").read_text(encoding="utf-8").splitlines()]

    def line_of(self, number):
        """The number of the line of a command."""
        [found] = [i for i, line in enumerate(self.capture.lines, 1) if line.get("n") == number]
        return found

    def test_the_same(self):
        self.rewrite()
        for file in self.old.rglob("*.*"):
            self.assertEqual((self.new / file.relative_to(self.old)).read_bytes(), file.read_bytes())
        self.assertEqual(len(list(self.old.rglob("*"))), len(list(self.new.rglob("*"))))

    def test_made_of_what_was_read(self):
        """Also what is not known stays, and the order of the keys."""
        self.rewrite("all")
        self.assertEqual([list(line.items()) for line in self.lines()],
                         [list(line.items()) for line in self.capture.lines])

    def test_without_a_line(self):
        at = self.line_of(3)
        self.rewrite("without", at)
        self.assertEqual(self.lines(), self.capture.lines[:at - 1] + self.capture.lines[at:])
        self.rewrite("without", at, status=1)  # the folder exists

    def test_without_a_geometry(self):
        at = self.line_of(1)
        first, second = self.capture.lines[at - 1]["geometry"]
        self.rewrite("geometry", at, 0)
        self.assertEqual(self.lines()[at - 1]["geometry"], [second])
        unused = {each["data"] for each in first["inputs"]} - {
            each["data"] for line in self.lines() for geometry in line.get("geometry", ()) for each in geometry["inputs"]}
        self.assertTrue(unused)
        for data in unused:
            self.assertFalse((self.new / "data" / f"{data}.npy").exists())

    def test_a_new_array(self):
        at = self.line_of(1)
        self.rewrite("cut", at)
        given = self.lines()[at - 1]["geometry"][0]["inputs"][0]
        self.assertEqual(given["count"], 1)
        content = (self.new / "data" / f"{given['data']}.npy").read_bytes()
        self.assertEqual(content, npy("<f4", "(1, 3)", struct.pack("<3f", 0, 0, 0)))
        self.rewrite("cut", at, status=1)

    def test_failures(self):
        self.new.mkdir()
        self.assertEqual(self.rewrite(status=1), f"{self.new}: File exists\n")
        self.new = self.old / "builds.jsonl" / "new"
        self.assertIn("Not a directory", self.rewrite(status=1))


class Fuzz(Case):
    def test_damaged_captures(self):
        """tests/scene/fuzz.c changes their files at random."""
        capture = scene(self.folder)
        capture.finding(1, "pInfos[0].pGeometries[0]", "primitive 1")
        capture.finding(5, "pInfos[0].pGeometries[0]", "instance 1")
        scratch = self.place / "scratch"
        (scratch / "data").mkdir(parents=True)
        subprocess.run([sys.argv[1], capture.write(), scratch, sys.argv[3]], check=True)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], sys.argv[2]])
