#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Baselines: written, read, outdated; what their lines match."""

import unittest

from runs import VUID, Runs, finding, main
from assay_run.baseline import Entry, baseline_line, read_baseline, split_known

NAMED = {"Objects": [{"type": "VkBuffer", "handle": "0x1", "name": "mesh 1"},
                     {"type": "VkDevice", "handle": "0x2"}]}
MISTAKE = "load(); find(Objects=[{'type': 'VkBuffer', 'handle': '0x1', 'name': 'mesh 1'}]); end()"
OTHER = MISTAKE.replace("mesh 1", "mesh 2")


class Lines(unittest.TestCase):
    def matches(self, line, **members):
        return Entry(line, "known.txt", 1).matches(finding(**members))

    def test_id(self):
        self.assertTrue(self.matches(VUID))
        self.assertFalse(self.matches(VUID + "x"))

    def test_retired_id(self):
        self.assertTrue(self.matches("VUID-old", formerly=["VUID-old"]))

    def test_second_id_of_a_mistake(self):
        """It makes the line used, but the finding not known: its first id is another rule's."""
        entries = [Entry("VUID-second", "", 1), Entry("VUID-second@mesh 2", "", 2)]
        one = finding(also=["VUID-second"], **NAMED)
        self.assertEqual(split_known([one], entries), ([one], []))
        self.assertEqual([entry.used for entry in entries], [1, 0])
        entries.append(Entry(VUID, "", 3))
        self.assertEqual(split_known([one], entries), ([], [one]))
        self.assertEqual(baseline_line(one), f"{VUID}@mesh 1")

    def test_glob(self):
        for glob, expected in (("mesh 1", True), ("mesh*", True), ("mesh ?", True), ("mesh", False),
                               ("*2", False), ("MESH*", False), ("mesh [12]", True)):
            self.assertEqual(self.matches(f"{VUID}@{glob}", **NAMED), expected, glob)

    def test_glob_needs_a_name(self):
        self.assertFalse(self.matches(f"{VUID}@*"))

    def test_labels(self):
        for glob, expected in (("frame", True), ("std::vector<int>", True), ("shadows", True),
                               ("frame::std::vector<int>::shadows", True), ("vector", False),
                               ("frames", False)):
            self.assertEqual(self.matches(f"{VUID}@{glob}",
                                          DebugRegion="frame::std::vector<int>::shadows"),
                             expected, glob)

    def test_written_lines_match_their_findings(self):
        names = ["mesh 1", "a*b?c[d]e", "#1", " edges ", "é🦆", "a@b", "x" * 10000, "line\nbreak",
                 "\x1b[31m", "]", "[!x]", "back\\slash"]
        for name in names:
            with self.subTest(name):
                one = finding(Objects=[{"type": "VkBuffer", "handle": "0x1", "name": name}])
                line = baseline_line(one)
                self.assertEqual(line, line.strip())
                self.assertTrue(line.isprintable())
                self.assertTrue(Entry(line, "known.txt", 1).matches(one))

    def test_written_labels(self):
        self.assertEqual(baseline_line(finding(DebugRegion="frame")), f"{VUID}@frame")
        self.assertEqual(baseline_line(finding(DebugRegion="frame::pass")), VUID)

    def test_uses_are_counted(self):
        entries = [Entry(VUID, "", 1), Entry("VUID-other", "", 2)]
        new, known = split_known([finding(), finding(), finding("VUID-new")], entries)
        self.assertEqual((len(new), len(known)), (1, 2))
        self.assertEqual([entry.used for entry in entries], [2, 0])


class Files(Runs):
    def test_comments(self):
        path = self.folder / "known.txt"
        path.write_text(f"\ufeff# all\n\n  {VUID}@mesh*  # of the loader\n", encoding="utf-8")
        self.assertEqual([entry.text for entry in read_baseline(path)], [f"{VUID}@mesh*"])

    def test_written_then_read(self):
        self.expect(self.run_script(MISTAKE, "--write-baseline", "known.txt"), 0)
        self.assertIn(f"{VUID}@mesh 1\n", self.read("known.txt"))
        self.assertEqual(self.run_script(MISTAKE, "--baseline", "known.txt").status, 0)
        self.expect(self.run_script(OTHER, "--baseline", "known.txt"), 99,
                    "known.txt:2: matches no finding any more")

    def test_outdated(self):
        (self.folder / "known.txt").write_text(f"{VUID}\n")
        clean = "load(); end()"
        self.expect(self.run_script(clean, "--baseline", "known.txt"), 0,
                    "known.txt:1: matches no finding any more")
        self.assertEqual(self.run_script(clean, "--baseline", "known.txt",
                                         "--strict-baseline").status, 99)
        self.assertEqual(self.run_script(MISTAKE, "--baseline", "known.txt",
                                         "--strict-baseline").status, 0)

    def test_a_signal_is_not_in_the_baseline(self):
        (self.folder / "known.txt").write_text(f"{VUID}\n")
        self.expect(self.run_script(MISTAKE + "; os.kill(os.getpid(), 11)", "--baseline", "known.txt"),
                    -11)

    def test_wrong_lines(self):
        for line in ("two ids", "@mesh", f"{VUID}@"):
            (self.folder / "known.txt").write_text(line)
            self.expect(self.run_script("load()", "--baseline", "known.txt"), 2, "known.txt:1")


if __name__ == "__main__":
    main()
