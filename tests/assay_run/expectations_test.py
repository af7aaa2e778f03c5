# SPDX-License-Identifier: Apache-2.0
"""Findings that the application announces by labels: expected, unexpected, and absent ones."""

import unittest
import xml.etree.ElementTree as ElementTree

from runs import TIME, VUID, Runs, finding, header, main
from assay_run.expectations import ids_of_label, is_expected

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
