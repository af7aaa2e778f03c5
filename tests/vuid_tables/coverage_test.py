# SPDX-License-Identifier: Apache-2.0
"""Tests of scripts/coverage, on tables and results made up here, and once on the real tables,
whose vuid_dump is named on the command line."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

COVERAGE = pathlib.Path(__file__).resolve().parents[2] / "scripts/coverage"
DUMP = sys.argv.pop() if len(sys.argv) > 1 else None

ROWS = (
    ("VUID-vkFoo-a-1", "a_is_good", "call", "parameters", "-", "vkFoo", "VUID-vkFoo-old-1",
     "Do a."),
    ("VUID-vkFoo-b-2", "b_is_good", "call", "state", "-", "vkFoo", "-", "-"),
    ("VUID-VkBar-c-3", "c_is_good", "-", "content", "glasses", "vkFoo", "VUID-vkFoo-old-1",
     "-"),
)
BOTH = ("VUID-vkFoo-a-1\tfired", "VUID-vkFoo-a-1\tsilent", "VUID-vkFoo-b-2\tfired",
        "VUID-vkFoo-b-2\tsilent")


class Coverage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "results").mkdir()
        (self.folder / "rows").write_text("".join("\t".join(row) + "\n" for row in ROWS))
        dump = self.folder / "dump"
        dump.write_text(f"#!/bin/sh\ncat '{self.folder / 'rows'}'\n")
        dump.chmod(0o755)
        (self.folder / "seeds").write_text("# ids\nVUID-vkFoo-b-2\nVUID-vkFoo-old-1\n")
        self.write_registry([row[0] for row in ROWS])

    def write_registry(self, names):
        groups = {"core": [{"vuid": name, "text": "", "page": ""} for name in names]}
        (self.folder / "validusage.json").write_text(json.dumps(
            {"version info": {"api version": "9.9.9"}, "validation": {"x": groups}}))

    def write_results(self, *lines, platform="null"):
        (self.folder / "results" / f"{platform}.tsv").write_text(
            "".join(f"{platform}\tcase\tvkFoo\t{line}\n" for line in lines))

    def run_script(self, *options):
        return subprocess.run(
            [sys.executable, COVERAGE, "--dump", self.folder / "dump", "--results",
             self.folder / "results", "--registry", self.folder, "--seeds",
             self.folder / "seeds", *options], capture_output=True, text=True, check=False)

    def check(self, status, firing, silent):
        run = self.run_script()
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertEqual(run.stdout.splitlines()[-1],
                         f"coverage: 2 implemented, {firing} firing, {silent} silent, 1 pending of "
                         "3; seeds: 1/2")
        return run.stdout

    def test_columns(self):
        self.write_results(*BOTH)
        self.write_results(BOTH[0], BOTH[1], BOTH[2], platform="other")
        run = self.run_script("--columns")
        self.assertIn("null: 0 of 2 pairs", run.stdout)
        self.assertIn("other: 1 of 2 pairs", run.stdout)
        self.assertIn("VUID-vkFoo-b-2 (b_is_good): vkFoo", run.stdout)

    def check_reasons(self, status, part):
        run = self.run_script("--columns", "--reasons", self.folder / "reasons")
        self.assertEqual(run.returncode, status, run.stdout)
        self.assertIn(part, run.stdout)

    def test_columns_with_reasons(self):
        reasons = self.folder / "reasons"
        reasons.write_text("# of what\nother\t*\tVUID-vkFoo-b-*\tit can't be\n")
        self.write_results(*BOTH, platform="other")
        self.check_reasons(1, "has a case, so its reason is not needed: VUID-vkFoo-b-*")
        self.write_results(*BOTH)
        self.write_results(*BOTH[:2], platform="other")
        self.check_reasons(0, "other: 1 of 2 pairs of an id and a command lack a case, 0 of them "
                              "without a reason\n  it can't be\n    VUID-vkFoo-b-2 (b_is_good): "
                              "vkFoo\n")
        self.write_results(*BOTH[2:], platform="other")
        self.check_reasons(1, "without a reason\n    VUID-vkFoo-a-1")
        reasons.write_text("other\t*\tVUID-vkFoo-b-2\n")
        self.assertEqual(self.run_script("--columns", "--reasons", reasons).returncode, 2)

    def test_all_is_proven(self):
        self.write_results(*BOTH)
        out = self.check(0, 2, 2)
        self.assertNotIn("without proof", out)
        self.assertIn("registry 9.9.9 has the same ids in scope", out)

    def test_proof_may_come_from_several_platforms(self):
        self.write_results(*BOTH[:2])
        self.write_results(*BOTH[2:], platform="lavapipe")
        run = self.run_script()
        self.assertEqual(run.returncode, 0)
        self.assertIn("lavapipe 2, null 2", run.stdout)

    def test_twin_is_missing(self):
        self.write_results(*BOTH[:3])
        self.assertIn("VUID-vkFoo-b-2 (b_is_good): no silent twin\n", self.check(1, 2, 1))
        self.assertEqual(self.run_script("--allow-gaps").returncode, 0)

    def test_failed_case_counts_for_nothing(self):
        self.write_results(*BOTH, "VUID-vkFoo-a-1\tfailed")
        self.assertIn("VUID-vkFoo-a-1 (a_is_good): a case failed\n", self.check(1, 1, 1))

    def test_nothing_ran(self):
        self.assertIn("run the tests first", self.check(1, 0, 0))

    def test_pending_by_capability(self):
        run = self.run_script("--pending")
        self.assertIn("pending until glasses: 1\n  VUID-VkBar-c-3 (c_is_good)\n", run.stdout)

    def test_registry_has_other_ids(self):
        self.write_registry([ROWS[0][0], ROWS[1][0], "VUID-VkBar-new-4", "VUID-VkElse-new-5"])
        out = self.run_script().stdout
        self.assertIn("vuids.def lacks: 1\n  VUID-VkBar-new-4\n", out)
        self.assertIn("registry 9.9.9 lacks: 1\n  VUID-VkBar-c-3\n", out)

    def test_table_splits_by_level(self):
        lines = self.run_script().stdout.splitlines()
        self.assertEqual(lines[1].split(), ["vkFoo", "2", "2", "0", "0", "0", "1", "1/1", "1/1"])
        self.assertEqual(lines[2].split(), ["VkBar", "1", "0", "0", "0", "1", "0", "0/1"])
        self.assertIn("by 1 of 3 rows)", lines[4])

    def test_malformed_inputs(self):
        for line in ("VUID-vkFoo-unknown-9\tfired", "VUID-vkFoo-a-1\tmaybe", "VUID-vkFoo-a-1"):
            self.write_results(line)
            run = self.run_script()
            self.assertEqual(run.returncode, 2)
            self.assertIn("null.tsv:1:", run.stderr)
        self.write_results()
        (self.folder / "seeds").write_text("VUID-vkFoo-elsewhere-1\n")
        self.assertEqual(self.run_script().returncode, 2)
        self.assertEqual(self.run_script("--dump", "/nonexistent").returncode, 2)

    @unittest.skipUnless(DUMP, "no vuid_dump given")
    def test_real_tables(self):
        run = subprocess.run([sys.executable, COVERAGE, "--dump", DUMP, "--results",
                              self.folder / "results", "--allow-gaps"],
                             capture_output=True, text=True, check=True)
        self.assertRegex(run.stdout.splitlines()[-1],
                         r"^coverage: \d+ implemented, 0 firing, 0 silent, \d+ pending of 1311; "
                         r"seeds: \d+/200$")


if __name__ == "__main__":
    unittest.main()
