# SPDX-License-Identifier: Apache-2.0
"""The build compiles each source of the tests: sources_test.py BUILD_DIRECTORY"""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(sys.argv.pop(1))
OTHERS = {"tests/windows", "tests/coverage"}  # only presets mingw and coverage compile these


class Sources(unittest.TestCase):
    def test_each_is_compiled(self):
        build = (BUILD / "build.ninja").read_text(encoding="utf-8")
        sources = {path.relative_to(ROOT) for path in ROOT.glob("tests/**/*.c")}
        self.assertGreater(len(sources), 100)
        left_out = [str(path) for path in sorted(sources)
                    if OTHERS.isdisjoint((str(path), str(path.parent))) and f"{path} " not in build]
        self.assertEqual(left_out, [])

    def test_programs_of_windows_exist(self):
        build = (BUILD / "build.ninja").read_text(encoding="utf-8")
        lines = (ROOT / "tests/windows/tests.txt").read_text(encoding="utf-8").splitlines()
        programs = [line.split()[1].removesuffix(".exe") for line in lines]
        self.assertEqual([name for name in programs if f"build tests/{name}: " not in build], [])


if __name__ == "__main__":
    unittest.main()
