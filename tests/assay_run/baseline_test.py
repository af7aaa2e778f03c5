# SPDX-License-Identifier: Apache-2.0
"""Baselines: what their lines match. layer_test.py has those that are written, read and outdated."""

import os
import unittest

from runs import VUID, Runs, finding, main
from assay_run.baseline import Entry, baseline_line, read_baseline, split_known

NAMED = {"Objects": [{"type": "VkBuffer", "handle": "0x1", "name": "mesh 1"},
                     {"type": "VkDevice", "handle": "0x2"}]}
MISTAKE = "load(); find(Objects=[{'type': 'VkBuffer', 'handle': '0x1', 'name': 'mesh 1'}]); end()"
FRAMES = [{"module": "/app", "offset": "0x10", "function": "load(Mesh*)", "file": "/src/mesh/load.cpp",
           "line": 3},
          {"module": "/app", "offset": "0x20", "function": "main", "file": "/src/main.cpp", "line": 4},
          {"module": "/lib/libc.so.6", "offset": "0x30", "function": "__libc_start"}]
FRAME = {"type": "VkCommandBuffer", "handle": "0x3", "name": "frame"}


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

    def test_functions(self):
        for glob, expected in (("load", True), ("load(Mesh[*])", True), ("main", True), ("lo*", True),
                               ("__libc_start", False), ("Mesh", False), ("mesh 1", False)):
            self.assertEqual(self.matches(f"{VUID}@fn:{glob}", call_site=FRAMES, **NAMED), expected, glob)
        self.assertFalse(self.matches(f"{VUID}@fn:*", **NAMED))
        self.assertFalse(self.matches(f"{VUID}x@fn:load", call_site=FRAMES))

    def test_files(self):
        for glob, expected in (("/src/main.cpp", True), ("*/mesh/*", True), ("main.cpp", False),
                               ("/src/mesh", False)):
            self.assertEqual(self.matches(f"{VUID}@file:{glob}", call_site=FRAMES), expected, glob)
        here = [{**FRAMES[0], "file": os.path.abspath("src/a.c")}]
        self.assertTrue(self.matches(f"{VUID}@file:src/*.c", call_site=here))
        self.assertFalse(self.matches(f"{VUID}@file:*"))

    def test_several_conditions(self):
        for condition, expected in (("mesh 1 & frame", True), ("mesh 1 & other", False),
                                    ("other & frame", False), ("fn:load & mesh *", True),
                                    ("fn:load & file:/src/main.cpp & frame", True), ("mesh 1&frame", False)):
            self.assertEqual(self.matches(f"{VUID}@{condition}", call_site=FRAMES, DebugRegion="frame",
                                          **NAMED), expected, condition)

    def test_written_functions(self):
        """A structure says what a mistake is about, and a function more than a command buffer."""
        one = finding(call_site=FRAMES, DebugRegion="frame", Objects=[FRAME])
        self.assertEqual(baseline_line(one), f"{VUID}@fn:load(Mesh[*])")
        self.assertTrue(Entry(baseline_line(one), "", 1).matches(one))
        self.assertEqual(baseline_line(finding(call_site=FRAMES, **NAMED)), f"{VUID}@mesh 1")
        self.assertEqual(baseline_line(finding(call_site=[{"module": "/a", "offset": "0x1"}])), VUID)
        self.assertEqual(baseline_line(finding(Objects=[FRAME, *NAMED["Objects"]])), f"{VUID}@mesh 1")

    def test_lines_that_name_a_command_buffer(self):
        for line, expected in ((f"{VUID}@frame", True), (f"{VUID}@mesh 1", False), (f"{VUID}@*", False),
                               (VUID, False), (f"{VUID}x@frame", False), (f"{VUID}@fn:load", False),
                               (f"{VUID}@frame & mesh 1", False), (f"{VUID}@frame & fr*", True)):
            entries = [Entry(line, "", 1)]
            split_known([finding(call_site=FRAMES, Objects=[FRAME, *NAMED["Objects"]])], entries)
            self.assertEqual(bool(entries[0].carriers), expected, line)
        entries = [Entry(f"{VUID}@frame", "", 1)]
        split_known([finding(DebugRegion="frame", Objects=[FRAME])], entries)
        self.assertFalse(entries[0].carriers)  # a label has the name, too

    def test_written_lines_match_their_findings(self):
        names = ["mesh 1", "a*b?c[d]e", "#1", " edges ", "é🦆", "a@b", "x" * 10000, "line\nbreak",
                 "\x1b[31m", "]", "[!x]", "back\\slash",
                 "fn:load", "file:*", "a & b"]
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

    def test_a_signal_is_not_in_the_baseline(self):
        (self.folder / "known.txt").write_text(f"{VUID}\n")
        self.expect(self.run_script(MISTAKE + "; os.kill(os.getpid(), 11)", "--baseline", "known.txt"),
                    -11)

    def test_line_that_names_a_command_buffer(self):
        (self.folder / "known.txt").write_text(f"{VUID}@frame\n")
        script = f"load(); find(Objects=[{FRAME}]); end()"
        self.expect(self.run_script(script, "--baseline", "known.txt"), 0,
                    f'known.txt:1: mutes {VUID} wherever it arises in VkCommandBuffer "frame"')

    def test_lines_that_need_call_sites(self):
        script = "load(); end(); sys.exit(3 + (os.environ.get('VK_ASSAY_VALIDATION_CALL_SITES') == 'full'))"
        for line, status in ((VUID, 3), (f"{VUID}@fn:load", 4), (f"{VUID}@file:*.c", 4)):
            (self.folder / "known.txt").write_text(line)
            self.expect(self.run_script(script, "--baseline", "known.txt"), status)
        self.expect(self.run_script(script, "--baseline", "known.txt", "--set", "call_sites=off"), 3)

    def test_wrong_lines(self):
        for line in ("two ids", "@mesh", f"{VUID}@", f"{VUID}@fn:", f"{VUID}@file:", f"{VUID}@ & a",
                     f"{VUID}@a & fn:"):
            (self.folder / "known.txt").write_text(line)
            self.expect(self.run_script("load()", "--baseline", "known.txt"), 2, "known.txt:1")


if __name__ == "__main__":
    main()
