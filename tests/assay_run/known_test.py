# SPDX-License-Identifier: Apache-2.0
"""Findings that do not count: those that lines of a baseline match (layer_test.py has baselines that are written, read
and outdated), and those that the application announces by labels: expected, unexpected, and absent ones."""

import os
import unittest
import xml.etree.ElementTree as ElementTree

from runs import TIME, VUID, Runs, finding, header, main
from assay_run.baseline import Entry, baseline_line, read_baseline, split_known
from assay_run.expectations import ids_of_label, is_expected

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


LABEL = f"assay:expect {VUID}"
REGION = f"frame::{LABEL}::std::vector<int>"
OTHER = "VUID-other"


def opened(label=LABEL, **members):
    return {"Type": "Expectation", "pid": 7, "time": TIME, "device": "0x1", "label": label, **members}


class Labels(unittest.TestCase):
    def test_ids(self):
        for label, expected in ((LABEL, [VUID]), (f"{LABEL}, {OTHER}", [VUID, OTHER]),
                                (f"{LABEL} {OTHER} # VUID-no", [VUID, OTHER]),
                                ("assay:expect", []), ("assay:expect # why", []),
                                ("assay:expected " + VUID, None), ("frame", None), ("", None)):
            self.assertEqual(ids_of_label(label), expected, label)

    def test_findings(self):
        for region, expected in ((LABEL, True), (REGION, True), (f"{LABEL}::assay:expect {OTHER}", True),
                                 (f"assay:expect {OTHER}", False), (VUID, False), ("", False),
                                 (f"{LABEL}x", False), (f"{LABEL} # a::b", True)):
            self.assertEqual(is_expected(finding(DebugRegion=region)), expected, region)
        self.assertFalse(is_expected(finding()))

    def test_retired_id(self):
        self.assertTrue(is_expected(finding("VUID-new", formerly=[VUID], DebugRegion=LABEL)))

    def test_second_id_of_a_mistake(self):
        self.assertFalse(is_expected(finding("VUID-new", also=[VUID], DebugRegion=LABEL)))


class Expectations(Runs):
    def merge(self, status, *lines, options=()):
        """Returns the result, with these lines in the record of a process."""
        self.write_record(header(), *lines)
        return self.expect(self.run_words("--merge", "7.jsonl", "--junit", "a.xml", "--sarif", "a.sarif",
                                          "--json", "a.json", "--github", *options), status)

    def kinds(self):
        """Returns the cases of the JUnit report, with the kinds of their results."""
        suite = ElementTree.parse(self.folder / "a.xml").getroot()[0]
        return {case.get("name"): [child.tag for child in case] for case in suite}

    def test_expected_finding(self):
        result = self.merge(0, opened(), finding(DebugRegion=REGION), finding(DebugRegion=REGION))
        self.assertIn("0 findings in 1 process; 1 expected finding", result.err)
        self.assertEqual(self.kinds(), {"the run": [], f"expected: {VUID}": []})
        [one] = self.load("a.sarif")["runs"][0]["results"]
        self.assertEqual(one["suppressions"][0]["kind"], "inSource")
        self.assertEqual(len(self.load("a.json")["expected"]), 2)
        self.assertEqual(result.out, "")

    def test_finding_outside(self):
        self.merge(99, opened(), finding(DebugRegion=REGION), finding(DebugRegion="frame"))
        self.assertEqual(self.kinds()[VUID], ["failure"])

    def test_other_finding_inside(self):
        self.merge(99, opened(), finding(DebugRegion=REGION), finding(OTHER, DebugRegion=REGION))
        self.assertEqual(self.kinds()[OTHER], ["failure"])

    def test_absent_finding(self):
        text = f'{VUID}: expected in the region "{LABEL}", but not reported'
        result = self.merge(99, opened())
        self.assertIn(text, result.err)
        self.assertIn("0 findings in 1 process", result.err)
        self.assertEqual(self.kinds(), {"the run": [], f"expected: {VUID}": ["failure"]})
        self.assertEqual(self.load("a.json")["absent"], [{"VUID": VUID, "label": LABEL}])
        self.assertEqual(result.out, f"::error title=Assay::{text}\n")

    def test_one_of_several_is_absent(self):
        """A comment tells regions apart; each id of a label is expected."""
        label = f"{LABEL} {OTHER} # a::b"
        self.assertIn(f"{OTHER}: expected", self.merge(99, opened(label), finding(DebugRegion=label)).err)
        self.merge(0, opened(label), finding(DebugRegion=label), finding(OTHER, DebugRegion=label))
        self.merge(99, opened(LABEL + " # 1"), opened(LABEL + " # 2"), finding(DebugRegion=LABEL + " # 1"))

    def test_processes(self):
        """The finding of one process is not that of another one."""
        self.merge(0, opened(), opened(), finding(DebugRegion=LABEL))
        self.merge(99, opened(), opened(pid=8), finding(DebugRegion=LABEL))

    def test_second_id_is_not_absent(self):
        result = self.merge(99, opened(), finding(OTHER, also=[VUID], DebugRegion=LABEL))
        self.assertNotIn("but not reported", result.err)

    def test_warning_is_not_absent(self):
        self.merge(0, opened("assay:expect ASSAY-w"),
                   finding("ASSAY-w", Severity="Warning", DebugRegion="assay:expect ASSAY-w"))

    def test_held_back(self):
        """The limit of messages may have held back those of this region."""
        self.merge(0, opened(), {"Type": "Summary", "pid": 7, "Findings": {}, "HeldBack": {VUID: 3},
                                 "Unchecked": []})

    def test_label_without_id(self):
        self.assertIn("an id: expected", self.merge(99, opened("assay:expect")).err)

    def test_baseline(self):
        """What is expected is neither written to a baseline nor a use of its lines."""
        self.merge(0, finding(DebugRegion=LABEL), options=("--write-baseline", "known.txt"))
        self.assertNotIn(VUID, self.read("known.txt"))
        (self.folder / "known.txt").write_text(VUID)
        self.merge(99, finding(DebugRegion=LABEL), options=("--baseline", "known.txt",
                                                            "--strict-baseline"))

    def test_first_finding(self):
        script = f"load(); find(DebugRegion={LABEL!r}); time.sleep(0.5); end(); sys.exit(4)"
        self.expect(self.run_script(script, "--stop-at-first"), 4)
        script = f"load(); write({opened()}); find(); time.sleep(600)"
        self.assertNotIn("but not reported",
                         self.expect(self.run_script(script, "--stop-at-first"), 99).err)


if __name__ == "__main__":
    main()
