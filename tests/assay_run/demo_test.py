# SPDX-License-Identifier: Apache-2.0
"""The demo's planted mistakes on the page. ASSAY_TEST_SCREENSHOT names a file for a picture of it."""

import os
import pathlib
import subprocess
import sys

from browser import CHROMIUM, Browser
from runs import Runs, main
from assay_run.scene import find_three

DEMO, LAYERS = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
MESH = pathlib.Path("/usr/share/glmark2/models/bunny.obj")
PLANTED = 24


class Demo(Runs):
    def test_page(self):
        (self.folder / "assay_demo").symlink_to(DEMO)
        self.expect(self.run_words(
            "--lavapipe", "--level", "content", "--html", "a.html",
            "--json", "a.json", "--", "./assay_demo", VK_LAYER_PATH=str(LAYERS)), 99)
        found = self.load("a.json")["new"]
        browser = Browser(self.folder)
        self.addCleanup(browser.close)
        self.assertLess((self.folder / "a.html").stat().st_size, 5_000_000)
        browser.open(self.folder / "a.html", 1000, 1300)
        self.assertIn("7 instances of 3 structures, 349,290 primitives", browser.run(
            "get('scene-summary').textContent"))
        browser.run("select({ item: scene.items[0], geometry: 0, primitive: 4711 })")
        self.assertIn("geometry 0, opaque: triangle 4711", browser.run("get('scene-object').textContent"))
        self.assertEqual(browser.console, [])
        self.assertEqual(browser.run("document.querySelectorAll('.finding').length"), len(found))
        self.assertEqual(len({one["VUID"] for one in found}), PLANTED)
        text = browser.run("document.body.innerText")
        for one in found:
            self.assertIn(one["VUID"], text)
        if os.environ.get("ASSAY_TEST_SCREENSHOT"):
            pathlib.Path(os.environ["ASSAY_TEST_SCREENSHOT"]).write_bytes(browser.screenshot())


if __name__ == "__main__":
    lavapipe = subprocess.run(["sh", "-c", "ls /usr/share/vulkan/icd.d/lvp_icd*"],
                              capture_output=True, check=False).returncode == 0
    if not CHROMIUM or not lavapipe or not MESH.exists() or not find_three(os.environ):
        print("needs Chromium, lavapipe, three.js and the mesh of glmark2-data")
        sys.exit(77)
    main()
