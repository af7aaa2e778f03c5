# SPDX-License-Identifier: Apache-2.0
"""assay-scene reads all that the layer captures, whatever programs do: on the null driver.

usage: layer_test.py ASSAY_SCENE PROGRAMS"""

import json
import os
import subprocess
import sys
import unittest

from captures import Case, run
from gltf import Gltf

PROGRAMS = sys.argv[2]


class Layer(Case):
    def test_programs(self):
        folder = self.place
        for platform, programs in (("null", "snapshots"), ("null", "life"), ("cpu_null", "execution")):
            subprocess.run([PROGRAMS, platform, programs], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL,
                           env={**os.environ, "VK_ASSAY_VALIDATION_CAPTURE": f"{folder}/capture-%p"})
        triangles = red = builds = 0
        for capture in folder.glob("capture-*"):
            status, out, err = run("info", capture, "--json")
            self.assertEqual((status, err), (0, ""))
            builds += sum(row["builds"] for row in json.loads(out)["structures"])
            self.assertEqual(run("export", capture, folder / "scene.glb"), (0, "", ""))
            self.assertEqual(run("view", capture, folder / "view.json"), (0, "", ""))
            gltf = Gltf(folder / "scene.glb")
            triangles += sum(gltf.root["accessors"][primitive["indices"]]["count"] // 3  # some have a million
                             for mesh in gltf.root.get("meshes", ()) for primitive in mesh["primitives"])
            red += sum("findings" in part["extras"] for parts in (
                gltf.nodes(), *(mesh["primitives"] for mesh in gltf.root.get("meshes", ()))) for part in parts)
        self.assertGreater(builds, 300)
        self.assertGreater(triangles, 100)
        self.assertGreater(red, 10)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
