# SPDX-License-Identifier: Apache-2.0
"""assay-scene view: the data of the 3D view, read without JavaScript.

view_test.py ASSAY_SCENE"""

import base64
import json
import struct
import sys
import unittest

import captures
from captures import IDENTITY, NAN, Capture, Case, run

MOVED = (1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0)
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
QUAD = [0, 1, 2, 0, 2, 3]


class View(Case):
    def view(self, capture, *options):
        status, out, error = run("view", capture.write(), self.place / "view.json", *options)
        self.assertEqual((status, out, error), (0, "", ""))
        return json.loads((self.place / "view.json").read_text("utf-8"))

    def array(self, view, index, code):
        data = base64.b64decode(view["arrays"][index], validate=True)
        return [values[0] for values in struct.iter_unpack(f"<{code}", data)]

    def rows(self, view, moment):
        """The rows of instances: matrix, custom index and mask, offset and flags, structure, number."""
        data = base64.b64decode(view["arrays"][view["rows"]])
        return [struct.unpack_from("<12f4I", data, 64 * row) for row in self.array(view, moment["instances"], "I")]

    def test_moments(self):
        """The top-level structure comes first; what it holds, also by a copy, is shown with it alone."""
        view = self.view(captures.scene(self.folder))
        numbers = [(view["writes"][moment["write"]]["n"], moment["isTop"]) for moment in view["moments"]]
        self.assertEqual(numbers, [(7, True), (3, False)])
        top = view["moments"][0]
        self.assertEqual(top["leftOut"], {"instances without a structure": 1,
                                          "instances that refer to no known structure": 1})
        rows = self.rows(view, top)
        self.assertEqual([row[14:] for row in rows], [(2, 0), (1, 1), (0, 2)])
        self.assertEqual((rows[1][3], rows[1][12:14]), (10, (7 | 1 << 24, 9 | 1 << 24)))
        pairs = zip(top["contents"][::2], top["contents"][1::2])
        held = {view["writes"][write]["structure"]: (view["writes"][write]["mode"], view["meshes"][mesh])
                for write, mesh in pairs}
        self.assertEqual(held[2][0], "compact")
        self.assertEqual(held[2][1], held[0][1])  # what was copied
        self.assertEqual(held[0][1]["leftOut"], {"inactive primitives": 1})
        self.assertEqual(held[0][1]["box"], [5, 0, 0, 7, 2, 0])
        geometry = held[0][1]["geometries"][0]
        self.assertEqual(self.array(view, geometry["positions"], "f")[:6], [5, 0, 0, 7, 0, 0])
        self.assertEqual(self.array(view, geometry["indices"], "I"), QUAD)
        self.assertEqual((geometry["primitives"], geometry["count"], geometry["opaque"]), (None, 2, True))
        boxes = held[1][1]["geometries"][0]
        self.assertEqual((boxes["each"], boxes["shown"], self.array(view, boxes["primitives"], "I")), (36, 1, [0]))

    def test_frames(self):
        """Rows that do not change are there once, each moment has what was built by then."""
        capture = Capture(self.folder)
        capture.structure(2, "top level", name="world")
        for frame in range(3):
            capture.build(1, capture.triangles([(frame, 0, 0), (1, 0, 0), (0, 1, 0)]),
                          mode="update" if frame else "build", frame=frame)
            capture.build_top(2, [(IDENTITY, 1), ((*MOVED[:3], frame, *MOVED[4:]), 1)], frame=frame)
        view = self.view(capture)
        self.assertEqual([view["writes"][moment["write"]]["frame"] for moment in view["moments"]], [2, 1, 0])
        self.assertEqual(len(base64.b64decode(view["arrays"][view["rows"]])), 64 * 4)
        for moment, frame in zip(view["moments"], (2, 1, 0)):
            self.assertEqual(self.rows(view, moment)[1][3], frame)
            write, mesh = moment["contents"]
            self.assertEqual(view["writes"][write]["mode"], "update" if frame else "build")
            positions = view["meshes"][mesh]["geometries"][0]["positions"]
            self.assertEqual(self.array(view, positions, "f")[0], frame)

    def test_limit(self):
        """A mesh without room has its box; earlier moments are left out and counted."""
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(i, i % 7, 0) for i in range(60000)]))
        capture.build(2, capture.triangles([(i, 0, i % 7) for i in range(60000)]))
        for frame in range(3):
            capture.build_top(3, [(IDENTITY, 1), (MOVED, 2)], frame=frame)
        view = self.view(capture, "--limit", "1")
        self.assertEqual((len(view["moments"]), view["leftOut"]), (1, 2))
        first, second = view["meshes"]
        self.assertIsNotNone(first["geometries"][0]["positions"])
        self.assertEqual((second["geometries"][0]["positions"], second["box"]), (None, [0, 0, 0, 59999, 0, 6]))

    def test_many_instances(self):
        """Of the first moment, what has room is shown, and the rest is counted."""
        capture = Capture(self.folder)
        capture.build(1, capture.triangles(CORNERS, QUAD))
        capture.build_top(2, [((1, 0, 0, i, *IDENTITY[4:]), 1) for i in range(20000)])
        view = self.view(capture, "--limit", "1")
        [moment] = view["moments"]
        self.assertEqual(len(self.rows(view, moment)) + moment["noRoom"], 20000)
        self.assertGreater(moment["noRoom"], 1000)

    def test_structures(self):
        """Memory, and when they were alive, of those that were at a moment which is shown."""
        capture = Capture(self.folder)
        for number in (1, 2, 3):
            capture.structure(number, name=f"mesh {number}" if number > 1 else None)
        capture.build(3, capture.triangles([(NAN, 0, 0)] * 3))
        capture.command("Destroyed", dst_id=3)
        capture.build(1, capture.triangles(CORNERS, QUAD))
        capture.command("Destroyed", dst_id=1)
        capture.build(2, capture.triangles(CORNERS, QUAD))
        capture.add("End", why="capture_limit_mib was reached")
        view = self.view(capture)
        self.assertEqual(view["structures"]["0"], {
            "handle": "0x1001", "type": "bottom level", "size": 256, "born": 3, "died": 4, "memory": 1, "offset": 0})
        self.assertEqual(view["structures"]["1"]["name"], "mesh 2")
        self.assertEqual((view["end"], view["meshes"][-1]["box"]), ("capture_limit_mib was reached", None))

    def test_use_after_destruction(self):
        """A structure that a build names is there, whatever the capture says of its life."""
        capture = Capture(self.folder)
        capture.structure(2, "top level")
        capture.build(1, capture.triangles(CORNERS, QUAD))
        capture.command("Destroyed", dst_id=1)
        capture.command("Destroyed", dst_id=2)
        capture.build_top(2, [(IDENTITY, 1)])
        self.assertEqual(sorted(self.view(capture)["structures"]), ["0", "1"])

    def test_nothing(self):
        capture = Capture(self.folder)
        view = self.view(capture)
        self.assertEqual((view["moments"], view["meshes"], view["structures"], view["end"]), ([], [], {}, None))

    def test_mistakes(self):
        capture = captures.scene(self.folder).write()
        for words in (("--limit", "0"), ("--limit", "x"), ("--limit", "5000"), ("--at", "frame:1")):
            self.assertEqual(run("view", capture, self.place / "view.json", *words)[0], 2)
        status, _, error = run("view", capture, self.place / "no/view.json")
        self.assertEqual((status, error), (2, f"assay-scene: {self.place}/no/view.json: cannot be written\n"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
