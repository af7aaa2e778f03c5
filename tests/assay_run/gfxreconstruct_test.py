# SPDX-License-Identifier: Apache-2.0
"""Captures and replays of gfxreconstruct under Assay, on the null driver: its addresses are the same in
the replay as in the capture, as on drivers that can replay addresses."""

import pathlib
import shutil
import sys
import unittest

from runs import Runs, main

APPLICATION, LAYERS, DRIVER = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
SYSTEM_LAYERS = pathlib.Path("/usr/share/vulkan/explicit_layer.d")
STEPS = ("clean", "scratch", "clean", "submit")


@unittest.skipUnless(shutil.which("gfxrecon-replay") and
                     (SYSTEM_LAYERS / "VkLayer_gfxreconstruct.json").exists(),
                     "gfxreconstruct is not installed")
class Gfxreconstruct(Runs):
    def run_under_assay(self, record, *command, **environment):
        """Returns the status, and the lines of the record by Type."""
        result = self.run_words(
            "--set", "record_builds=true", "--record", record, "--", *command,
            VK_LAYER_PATH=f"{LAYERS}:{SYSTEM_LAYERS}", VK_DRIVER_FILES=str(DRIVER),
            VK_LOADER_LAYERS_DISABLE="~implicit~", **environment)
        [path] = (self.folder / record).glob("*/*.jsonl")
        types = [line[len('{"Type":"'):].partition('"')[0]
                 for line in path.read_text(encoding="utf-8").splitlines()]
        return result.status, {name: types.count(name) for name in types}

    def test_replay_finds_what_the_application_did(self):
        captured = self.run_under_assay("capture", APPLICATION, *STEPS,
                                        VK_INSTANCE_LAYERS="VK_LAYER_LUNARG_gfxreconstruct",
                                        GFXRECON_CAPTURE_FILE=str(self.folder / "a.gfxr"))
        self.assertEqual(captured[0], 99)
        self.assertGreater(captured[1]["Build"], STEPS.index("submit"))
        [capture] = self.folder.glob("a*.gfxr")
        self.assertEqual(self.run_under_assay("replay", "gfxrecon-replay", capture), captured)


if __name__ == "__main__":
    main()
