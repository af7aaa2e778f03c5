# SPDX-License-Identifier: Apache-2.0
"""assay-scene report with a device, and assay-run --scene: the demo on lavapipe.

device_test.py ASSAY_SCENE DEMO LAYER_FOLDER LAVAPIPE_MANIFEST CASE..."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCENE, DEMO, LAYERS, LAVAPIPE = sys.argv[1:5]
ASSAY_RUN = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts/assay-run"


def run(*words, manifest=LAVAPIPE, **environment):
    return subprocess.run([*map(str, words)], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=600,
                          check=False, env={**os.environ, "VK_DRIVER_FILES": manifest, "VK_ICD_FILENAMES": manifest,
                                            "VK_LAYER_PATH": LAYERS, **environment})


class AssayRun(unittest.TestCase):
    def test_scene(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        page = pathlib.Path(folder.name) / "scene.html"
        result = run(ASSAY_RUN, "--scene", page, "--", DEMO, "--no-picture")
        self.assertEqual(result.returncode, 99, result.stderr)  # the demo's findings
        self.assertIn("assay-scene: accuracy in time", result.stderr)
        text = page.read_text("utf-8")
        self.assertIn("llvmpipe", text)
        self.assertLess(len(text), 5 << 20)


class Device(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.capture = cls.folder / "capture"
        result = run(ASSAY_RUN, "--capture", cls.capture, "--", DEMO, "--no-picture")
        assert result.returncode == 99, result.stderr

    def report(self, **members):
        result = run(SCENE, "report", self.capture, "--json", self.folder / "report.json", "--rays", 500, **members)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads((self.folder / "report.json").read_text("utf-8"))

    def test_sizes_and_times(self):
        """Sizes are those that the demo has asked the driver for; times are near those of a replay."""
        device = self.report()["device"]
        lines = [json.loads(line) for line in (self.capture / "builds.jsonl").read_text("utf-8").splitlines()]
        sizes = {line["name"]: line["size"] for line in lines if line["Type"] == "Structure" and "name" in line}
        rows = {row["flags"]: row for row in device["flags"]}
        self.assertEqual(rows["PREFER_FAST_TRACE"]["bytes"], sum(sizes[name] for name in (
            "mesh BLAS", "twisted BLAS", "box BLAS", "TLAS")))
        compacted = rows["PREFER_FAST_TRACE | ALLOW_COMPACTION"]
        self.assertLessEqual(compacted["compacted bytes"], compacted["bytes"])
        replay = run(SCENE, "replay", self.capture, "--time", "--repeat", 3).stdout.splitlines()
        times = sum(float(line.split()[3]) for line in replay if line.endswith(("mesh BLAS", "twisted BLAS"))) / 1000
        self.assertGreater(rows["PREFER_FAST_TRACE"]["ms build"], times / 30)
        self.assertLess(rows["PREFER_FAST_TRACE"]["ms build"], times * 30)

    def test_rays(self):
        report = self.report()
        rows = {row["set"]: row for row in report["device"]["rays"]}
        self.assertEqual(list(rows), [each["rays"] for each in report["accuracy"]["sets"]])
        self.assertEqual(rows["camera"]["wrong"], 0)
        self.assertGreater(rows["vertices"]["wrong"], 1000)
        for row in rows.values():
            self.assertLess(row["nearest"], 500000)
            self.assertGreater(row["ns a ray"], 0)

    def test_no_device(self):
        self.assertIn("No device has built the scene: the Vulkan loader found no driver",
                      self.report(manifest="/nonexistent")["device"]["missing"])
        result = run(SCENE, "report", self.capture, "--json", self.folder / "report.json", "--rays", 500, "--device", "x")
        self.assertEqual(result.returncode, 0, result.stderr)
        device = json.loads((self.folder / "report.json").read_text("utf-8"))["device"]
        self.assertIn("no device of that name has", device["missing"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
