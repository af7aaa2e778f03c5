# SPDX-License-Identifier: Apache-2.0
"""The shell lines of the documents do what they say: they are executed on lavapipe, as a reader would.

usage: commands_test.py BUILD PROGRAMS_TEST ASSAY_SCENE

`./app` is a program of the tests with two findings."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from documents_test import PAGES, ROOT, shell_blocks

FINDING = "VUID-VkAabbPositionsKHR-minX-03546"
EXECUTED_ELSEWHERE = {  # the beginning of a line, and what executes it
    "scripts/setup --layer": "scripts/test, which begins with scripts/setup",
    "cmake --preset layer && ": "scripts/demo",
    "cmake --preset quick && ": "scripts/test",
    "cmake --install build/layer": "scripts_uninstall",
    "cmake --build --preset layer --target uninstall": "scripts_uninstall",
    "(cd build/layer && cpack)": "scripts_package",
    "apt-get install ./build/layer/assay_": "scripts/packages",
    'assay-scene export capture scene.glb --tlas "shadows"': "scene_export",
    "VK_INSTANCE_LAYERS=VK_LAYER_LUNARG_gfxreconstruct ": "assay_run_layer",
    "assay-run --html assay.html -- gfxrecon-replay ": "assay_run_layer",
    "VK_ADD_LAYER_PATH=$PWD/build/layer/explicit_layer.d VK_INSTANCE_LAYERS=VK_LAYER_ASSAY_validation wine ":
        "scripts/windows",
}
# Programs that change no more than the folder of the test.
EXECUTED_HERE = r"(VK_\w+=\S+ )*(scripts/assay-run|assay-run|assay-scene|build/quick/tests/\S+|scripts/lint --form|./app)( |$)"
# What stands for something of the reader's own.
OF_THE_READER = {"frame:12": "submission:1", "VUID-...": FINDING,
                 "FOLDER/FILE": "snapshots/labels"}
FILTERS = {"programs_test": "findings"}


def blocks():
    for page in PAGES:
        for block in shell_blocks(page.read_text(encoding="utf-8")):
            yield str(page.relative_to(ROOT)), block.strip().splitlines()


class Commands(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="assay-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "scripts").symlink_to(ROOT / "scripts")
        (self.folder / "build").mkdir()
        for preset in ("layer", "quick"):
            (self.folder / "build" / preset).symlink_to(BUILD)
        app = self.folder / "app"
        app.write_text(f"#!/bin/sh\nexec {PROGRAMS} lavapipe snapshots/labels --filter 'findings at completion'\n",
                       encoding="utf-8")
        app.chmod(0o755)
        environment = {name: value for name, value in os.environ.items() if not name.startswith("VK_")}
        self.environment = {
            **environment, "PATH": f"{ROOT}/scripts:{SCENE.parent}:{environment['PATH']}",
            "VK_LAYER_PATH": f"{BUILD}/explicit_layer.d"}

    def execute(self, line):
        for words, value in OF_THE_READER.items():
            line = line.replace(words, value)
        for program, value in FILTERS.items():
            if program in line:
                line = line.replace("CASE", value)
        return subprocess.run(["bash", "-c", line], cwd=self.folder, env=self.environment, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", timeout=600)

    def test_lines(self):
        elsewhere, executed = set(EXECUTED_ELSEWHERE), 0
        # The first lines of pages that go on from there.
        for line in ("assay-run --capture capture -- ./app", "assay-run --record records -- ./app"):
            self.assertEqual(self.execute(line).returncode, 99)
        for page, lines in blocks():
            exports = ""
            shutil.rmtree(self.folder / "small", ignore_errors=True)
            for line in lines:
                begins = [words for words in EXECUTED_ELSEWHERE if line.startswith(words)]
                if begins:
                    elsewhere -= set(begins)
                    continue
                if line.startswith("export "):
                    exports += line + "\n"
                    continue
                with self.subTest(page=page, line=line):
                    self.assertRegex(line, "^" + EXECUTED_HERE)
                    run = self.execute(exports + line)
                    self.assertIn(run.returncode, (0, 99) if "./app" in line or "--merge" in line else (0,), run.stdout)
                executed += 1
        self.assertGreater(executed, 20)
        self.assertEqual(elsewhere, set(), "no page has these lines")


if __name__ == "__main__":
    BUILD, PROGRAMS, SCENE = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    unittest.main(argv=sys.argv[:1])
