# SPDX-License-Identifier: Apache-2.0
"""The counts of scripts/test --coverage: of gcov itself, with a program of two functions."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCRIPT = ROOT / "scripts" / "lib" / "lines.py"
SOURCE = """int called(int a)
{
    return a;
}
int never(int a)
{
    a++;
    return a;
}
int main(void)
{
    return called(0);
}
"""


class Lines(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        (self.root / "src" / "a").mkdir(parents=True)
        (self.root / "build").mkdir()
        (self.root / "src" / "a" / "b.c").write_text(SOURCE)

    def measure(self, *options):
        command = [sys.executable, "-B", SCRIPT, self.root, self.root / "build", *options]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_counts(self):
        for command in (["gcc", "--coverage", "-c", "../src/a/b.c"], ["gcc", "--coverage", "b.o"],
                        ["./a.out"]):
            subprocess.run(command, cwd=self.root / "build", check=True)
        run = self.measure()
        self.assertIn("4 of      7 lines   57.1 %", run.stdout.splitlines()[0])
        self.assertEqual(run.returncode, 1)
        self.assertEqual((self.root / "build" / "lines-missing.txt").read_text(),
                         "src/a/b.c: 5, 7-8\n")
        self.assertEqual(self.measure("--at-least", "57").returncode, 0)

    def test_nothing_built(self):
        run = self.measure()
        self.assertEqual(run.returncode, 1)
        self.assertIn("no object was built", run.stderr)


if __name__ == "__main__":
    unittest.main()
