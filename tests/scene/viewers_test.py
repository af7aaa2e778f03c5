# SPDX-License-Identifier: Apache-2.0
"""What others make of assay-scene's files: assimp, by tests/scene/assimp.c; or the validator of Khronos
(gltf-validator of npm, in a folder of NODE_PATH) and Blender.

usage: viewers_test.py ASSAY_SCENE [SCENE_ASSIMP]

Exits with 77 (skipped) if both of the latter are missing."""

import json
import shutil
import subprocess
import sys
import unittest

from captures import IDENTITY, NAN, Capture, Case, run, scene
from gltf import Gltf

VALIDATE = """
const validator = require("gltf-validator"), fs = require("fs");
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
    .then(report => console.log(JSON.stringify(report.issues)));
"""
IMPORT = """
import bpy, json, numpy, sys
numpy.bool = bool  # Debian 12's Blender uses it, and Debian 12's NumPy lacks it
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=sys.argv[-1])
triangles, points = 0, []
for item in bpy.context.scene.objects:
    if item.type == "MESH":
        triangles += len(item.data.polygons)
        points += [list(item.matrix_world @ vertex.co) for vertex in item.data.vertices]
# Its z axis is glTF's y axis.
points = [(x, z, -y) for x, y, z in points]
print("RESULT " + json.dumps([triangles, [[choice(column) for column in zip(*points)] for choice in (min, max)]]))
"""


def has_validator():
    return shutil.which("node") and subprocess.run(["node", "-e", 'require("gltf-validator")'], check=False,
                                                   stderr=subprocess.DEVNULL).returncode == 0


class Viewers(Case):
    def scenes(self):
        """Files with all that assay-scene writes, by name."""
        capture = scene(self.place / "scene")
        capture.finding(1, "pInfos[0].pGeometries[0].geometry", "has index 1 of primitive 1 is vertex 9")
        capture.finding(5, "pInfos[0].pGeometries[0].geometry", "leads to instance 2, whose transform ...")
        yield "scene", capture, []
        yield "flags", scene(self.place / "flags"), ["--color", "flags"]
        capture = Capture(self.place / "many")
        capture.structure(1, name="triangle \u00e9 \U0001f986")
        capture.build(1, capture.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))
        matrices = [(1, .5 * (i % 3), 0, i, 0, 2, 0, 0, 0, .1 * (i % 7), -1, 0) for i in range(400)]
        matrices += [(1, 0, 0, i, 0, 2, 0, 0, 0, 0, -1, 0) for i in range(200)] + [(0,) * 12]
        capture.build_top(2, [(matrix, 1) for matrix in matrices])
        yield "many", capture, []
        yield "nodes", capture, ["--plain-nodes"]
        capture = Capture(self.place / "empty")
        capture.build(1, capture.triangles([(NAN, 0, 0)] * 3))
        capture.build_top(2, [(IDENTITY, 1)])
        yield "empty", capture, []
        yield "nothing", Capture(self.place / "nothing"), []

    def files(self):
        for name, capture, options in self.scenes():
            file = self.place / f"{name}.glb"
            capture.write()
            self.assertEqual(run("export", capture.folder, file, *options), (0, "", ""))
            yield file

    @unittest.skipUnless(has_validator(), "gltf-validator is not installed")
    def test_validator(self):
        for file in self.files():
            issues = json.loads(subprocess.run(["node", "-e", VALIDATE, file], check=True,
                                               capture_output=True).stdout)
            messages = [message for message in issues["messages"] if message["severity"] < 2]
            self.assertEqual((issues["numErrors"], messages), (0, []), file)

    def expect_the_same(self, file, text):
        """`text`: how many triangles a reader has found, and their bounds."""
        triangles, bounds = json.loads(text)
        expected = Gltf(file).triangles()
        self.assertEqual(triangles, len(expected), file)
        corners = [corner for triangle in expected for corner in triangle]
        for choice, found in zip((min, max), bounds):
            for column, value in zip(zip(*corners), found):
                self.assertAlmostEqual(choice(column), value, 4)

    def files_without_extensions(self):
        """Those that have triangles, and that Debian's assimp and Blender know all of."""
        return (file for file in self.files() if file.stem in ("scene", "flags", "nodes"))

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_blender(self):
        for file in self.files_without_extensions():
            process = subprocess.run(
                ["blender", "--background", "--factory-startup", "--python-expr", IMPORT, "--", file], check=True,
                env={"PATH": "/usr/bin:/bin", "HOME": str(self.place)}, capture_output=True)  # the system's Python
            [line] = [line for line in process.stdout.decode().splitlines() if line.startswith("RESULT ")]
            self.expect_the_same(file, line[7:])


class Assimp(Viewers):
    test_validator = test_blender = None

    def test_assimp(self):
        for file in self.files_without_extensions():
            self.expect_the_same(file, subprocess.run([sys.argv[2], file], check=True, capture_output=True).stdout)


if __name__ == "__main__":
    if len(sys.argv) > 2:
        unittest.main(argv=[sys.argv[0], "Assimp"])
    if not has_validator() and not shutil.which("blender"):
        print("skipped: neither gltf-validator nor Blender is installed")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], "Viewers"])
