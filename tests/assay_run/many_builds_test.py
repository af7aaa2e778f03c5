#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of a real record: 10,000 builds with record_builds = true, in headless Chromium."""

import pathlib
import sys
import unittest

from browser import CHROMIUM, Browser
from runs import Runs, main

APPLICATION, LAYERS, DRIVER = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
BUILDS = 10000
STRUCTURES, SUBMISSIONS = BUILDS // 4, BUILDS // 20
COPIES = SUBMISSIONS  # one in each
UPDATES = BUILDS - STRUCTURES - COPIES


@unittest.skipUnless(CHROMIUM, "Chromium is not installed")
class ManyBuilds(Runs):
    def setUp(self):
        super().setUp()
        self.environment.update(VK_LAYER_PATH=str(LAYERS), VK_DRIVER_FILES=str(DRIVER),
                                VK_LOADER_LAYERS_DISABLE="~implicit~")
        self.expect(self.run_words("--html", "a.html", "--quiet",
                                   "--", APPLICATION, BUILDS), 99)
        self.browser = Browser(self.folder)
        self.addCleanup(self.browser.close)
        self.browser.open(self.folder / "a.html")

    def text(self, selector):
        return self.browser.run(f"document.querySelector({selector!r}).innerText")

    def count(self, selector):
        return self.browser.run(f"document.querySelectorAll({selector!r}).length")

    def test_page(self):
        self.assertLess((self.folder / "a.html").stat().st_size, 2_000_000)
        self.check_findings()
        self.check_time_line()
        self.check_structures()
        self.assertEqual(self.browser.console, [])

    def check_findings(self):
        """They are one mistake, which was made while several command buffers were recorded."""
        self.assertEqual(self.count(".finding"), 1)
        self.assertIn(f"{BUILDS // 1000} times", self.text(".finding"))
        self.assertRegex(self.text(".finding"), r"recorded in a command buffer of submission \d+")

    def check_time_line(self):
        self.assertEqual(self.count("#timeline .queue"), 2)
        self.assertEqual(self.count("#timeline button"), 2 * 84)  # three submissions each
        self.assertEqual(self.count("#timeline button.bad"), BUILDS // 1000)
        self.browser.run("document.querySelector('#timeline button.bad').focus()")
        self.assertRegex(self.text("#selected"),
                         r"Queue 0x\w+\. Submissions \d+ to \d+: 60 builds and copies, 1 finding")
        self.assertRegex(self.text("#commands"), r"update of “mesh \d+” 0x\w+ from “mesh \d+” 0x\w+, "
                         r"2 primitives, command buffer 0x\w+, build \d+")
        self.assertIn("and 40 more", self.text("#commands"))

    def check_structures(self):
        for part in (f"{STRUCTURES:,} structures", f"{STRUCTURES:,} builds", f"{UPDATES:,} updates",
                     f"{COPIES:,} copies", f"{SUBMISSIONS:,} submissions",
                     f"compacted sizes of {SUBMISSIONS:,} structures"):
            self.assertIn(part, self.text("#totals"))
        self.browser.run("structure.focus()")
        self.browser.type("“mesh 7”")
        row = self.text("#structures tr")
        for part in ("bottom level, destroyed", "command buffer", "build 8", "submission 1", "from “mesh 6”",
                     "16,384", "+ 114,688"):
            self.assertIn(part, row)
        self.browser.run("structure.value = ''")
        self.browser.type("“mesh 9”")
        self.assertIn("compacted copy of “mesh 8”", self.text("#structures tr"))


if __name__ == "__main__":
    main()
