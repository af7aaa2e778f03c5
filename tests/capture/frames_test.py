# SPDX-License-Identifier: Apache-2.0
"""A scene with refits, compactions and instances that the device writes, captured and replayed on lavapipe: the
structures have equal bytes, and rays have equal hits.

frames_test.py FRAMES ASSAY_SCENE LAYER_FOLDER MANIFEST MESHES INSTANCES COUNT"""

import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

from captures import Capture

FRAMES, SCENE, LAYERS, MANIFEST = sys.argv[1:5]
MESHES, INSTANCES, COUNT = map(int, sys.argv[5:8])
COMPACTED = len(range(2, MESHES, 4))
REFITTED = len(range(1, MESHES, 4))
RAYS = 100  # through each structure
COMPARES = {"compare_rays": RAYS, "duplicate_message_limit": 0, "log_format": "json", "debug_action": "log"}


def environment(**settings):
    return {**os.environ, "VK_DRIVER_FILES": MANIFEST, "VK_ICD_FILENAMES": MANIFEST, "VK_LAYER_PATH": LAYERS,
            "VK_ASSAY_VALIDATION_LEVEL": "content",
            **{f"VK_ASSAY_VALIDATION_{key.upper()}": str(value) for key, value in settings.items()}}


def play(folder, dump, **settings):
    subprocess.run([FRAMES, str(MESHES), str(INSTANCES), str(COUNT), dump], check=True, timeout=600,
                   env={**environment(capture=folder, **settings),
                        "VK_INSTANCE_LAYERS": "VK_LAYER_ASSAY_validation"})


def scene(*arguments, **settings):
    return subprocess.run([SCENE, *map(str, arguments)], env=environment(**settings), text=True, timeout=600, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE)


class FramesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        for name in ("dump", "again", "replayed"):
            (cls.folder / name).mkdir()
        play(cls.folder / "capture", cls.folder / "dump")
        cls.capture = Capture(cls.folder / "capture")
        cls.names = {line["structure"]: line["name"] for line in cls.capture.of_type("Structure")}

    def test_unchanged_inputs_are_written_once(self):
        refits = len([line for line in self.capture.of_type("Build") if line["mode"] == "update"])
        self.assertEqual(len(self.capture.of_type("Build")), MESHES + refits + COUNT)
        # The vertices of each mesh and refit, one array of indices, and the instances of each frame.
        self.assertEqual(len(self.capture.arrays), MESHES + refits + 1 + COUNT)
        self.assertEqual((self.folder / "capture/findings.jsonl").read_text("utf-8"), "")

    def test_replay(self):
        result = scene("replay", self.folder / "capture", "--dump", self.folder / "replayed")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn(f"copied: {COMPACTED}; not replayed: 0", result.stdout)
        self.check_bytes(self.names, self.folder / "dump", self.folder / "replayed")

    def check_bytes(self, names, dump, replayed):
        ids = {name: structure for structure, name in names.items()}
        for path in sorted(dump.iterdir()):
            before = path.read_bytes()
            after = (replayed / f"{ids[path.stem]}.bin").read_bytes()
            if path.stem == "top":
                self.check_top(before, after)
            else:
                self.assertTrue(before == after, path.stem)

    def check_top(self, before, after):
        """The bytes of the top level differ in the addresses of the others, each of which became one other."""
        self.assertEqual(len(before), len(after))
        became = {}
        for old, new in zip(struct.iter_unpack("<Q", before), struct.iter_unpack("<Q", after)):
            if old != new:
                self.assertEqual(became.setdefault(old, new), new)
        self.assertEqual(len(set(became.values())), len(became))
        self.assertLessEqual(len(became), MESHES)

    def test_kept(self):
        """A capture of the last frame has all that it refers to, if that was kept."""
        last = [line for line in self.capture.of_type("Build") if line["type"] == "top level"][-1]["submission"]
        play(self.folder / "bare", self.folder / "again", capture_from=f"submission:{last}")
        play(self.folder / "kept", self.folder / "again", capture_from=f"submission:{last}", capture_keep="true")
        bare = Capture(self.folder / "bare")
        self.assertGreater(len([line for line in bare.of_type("Structure") if "missing" in line]), 0)
        self.assertEqual(scene("replay", self.folder / "bare").returncode, 2 if REFITTED else 0)
        kept = Capture(self.folder / "kept")
        self.assertEqual([line for line in kept.of_type("Structure") if "missing" in line], [])
        tops = [line for line in kept.of_type("Build") if line["type"] == "top level"]
        self.assertEqual(len(tops), 1)
        names = {line["structure"]: line["name"] for line in kept.of_type("Structure")}
        for path in (self.folder / "replayed").iterdir():
            path.unlink()
        result = scene("replay", self.folder / "kept", "--dump", self.folder / "replayed")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.check_bytes(names, self.folder / "again", self.folder / "replayed")

    def test_hits(self):
        """lavapipe misses some hits and doubles others: those of the application and of the replay are the same."""
        play(self.folder / "compared", self.folder / "again", log_filename=self.folder / "before.jsonl", **COMPARES)
        result = scene("replay", self.folder / "compared", "--compare", log_filename=self.folder / "after.jsonl",
                       **COMPARES)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        before, after = (self.differences(self.folder / name) for name in ("before.jsonl", "after.jsonl"))
        self.assertGreater(len(before), 0)
        self.assertEqual(before, after)

    def differences(self, log):
        """Returns what is said of rays, in order, without what names objects."""
        lines = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
        messages = [line["MainMessage"] for line in lines if line.get("VUID", "").startswith("ASSAY-compare-")]
        for message in messages:
            self.assertIn(f" of {RAYS} rays", message)
        return [re.sub(" Command buffer .*", "", message) for message in messages]

    def test_viewers(self):
        """The exported scene has a node, or a row of an instanced one, for each instance."""
        result = scene("export", self.folder / "capture", self.folder / "scene.glb")
        self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[8:], verbosity=2)
