# SPDX-License-Identifier: Apache-2.0
"""assay-scene minimize: one bad index among many builds of three geometries becomes one build of one triangle.

minimize_test.py ASSAY_SCENE LAYER_FOLDER MANIFEST BUILDS TRIANGLES"""

import json
import os
import sys
import unittest

from captures import Capture, Case, run

BUILDS, TRIANGLES = map(int, sys.argv[4:6])
FINDING = "VUID-VkAccelerationStructureBuildRangeInfoKHR-maxVertex-10774"
SIZE = 1 << 24
OFFSET = 1 << 19  # of indices, behind the vertices


class MinimizeTest(Case):
    def test_one_bad_index(self):
        os.environ.update({"VK_DRIVER_FILES": sys.argv[3], "VK_ICD_FILENAMES": sys.argv[3],
                           "VK_LAYER_PATH": sys.argv[2]})
        capture = Capture(self.folder)
        capture.add("Memory", memory=2, size=SIZE)
        capture.add("Buffer", buffer=2, name="structures", memory=2, memory_offset=0, size=SIZE, usage="0x120000")
        vertices = [(i % 100, i // 100, i % 7) for i in range(1000)]
        for build in range(BUILDS):
            capture.add("Structure", structure=10 + build, handle=hex(0x2000 + build), type="bottom level", buffer=2,
                        offset=0, size=SIZE)
            geometries = []
            for number in range(3):
                indices = [(7 * i + build) % 1000 for i in range(3 * TRIANGLES)]
                if (build, number) == (BUILDS * 2 // 3, 1):
                    indices[TRIANGLES * 2] = 1000
                geometries.append(capture.triangles(vertices, indices))
                geometries[-1]["inputs"][1]["offset"] = OFFSET * (1 + number)
            capture.build(10 + build, *geometries, call=build + 1, info=0)
        status, out, err = run("minimize", capture.write(), self.place / "small", "--finding", FINDING)
        self.assertEqual((status, err), (0, ""), out)
        self.assertIn("left: 1 commands, 1 geometries, 1 primitives", out)
        lines = (self.place / "small/builds.jsonl").read_text("utf-8").splitlines()
        builds = [line for line in map(json.loads, lines) if line["Type"] == "Build"]
        self.assertEqual([build["dst_id"] for build in builds], [10 + BUILDS * 2 // 3])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
