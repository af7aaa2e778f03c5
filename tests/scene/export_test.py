# SPDX-License-Identifier: Apache-2.0
"""assay-scene export: the file, read back.

usage: export_test.py ASSAY_SCENE"""

import math
import pathlib
import random
import struct
import sys
import unittest

from captures import IDENTITY, NAN, Capture, Case, run, scene
from gltf import Gltf, apply

TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
RED = [0.8, 0, 0, 1]


def matrix_rows(matrix):
    return [matrix[0:4], matrix[4:8], matrix[8:12]]


class Export(Case):
    def setUp(self):
        super().setUp()
        self.file = self.place / "scene.glb"

    def export(self, capture, *options):
        capture.write()
        status, out, err = run("export", self.folder, self.file, *options)
        self.assertEqual((status, out, err), (0, "", ""))
        return Gltf(self.file)

    def expect_triangles(self, found, expected, tolerance=1e-5):
        """The same triangles, in any order, corner by corner."""
        self.assertEqual(len(found), len(expected))
        def key(triangle):
            return [round(value, 3) + 0.0 for corner in triangle for value in corner]
        for a, b in zip(sorted(found, key=key), sorted(expected, key=key)):
            for corner, other in zip(a, b):
                for x, y in zip(corner, other):
                    self.assertLessEqual(abs(x - y), tolerance * max(1, abs(y)), (a, b))

    def top(self, *geometry, instances=((IDENTITY, 1),), **members):
        capture = Capture(self.folder)
        capture.structure(1, name="mesh")
        capture.structure(2, "top level", name="world")
        capture.build(1, *(geometry or [capture.triangles(TRIANGLE)]), **members)
        if instances:
            capture.build_top(2, list(instances))
        return capture


class Meshes(Export):
    def test_scene(self):
        gltf = self.export(scene(self.folder))
        self.assertEqual(len(gltf.root["meshes"]), 3)
        self.assertEqual([node.get("name") for node in gltf.nodes()], ["compacted quad", "boxes", "quad"])
        self.assertEqual(gltf.nodes()[1]["extras"],
                         {"instance": 1, "customIndex": 7, "mask": 1, "sbtOffset": 9, "flags": 1})
        self.assertEqual(gltf.left_out(), {"inactive primitives": 3, "instances without a structure": 1,
                                           "instances that refer to no known structure": 1})
        quad = [((5, 0, 0), (7, 0, 0), (7, 2, 0)), ((5, 0, 0), (7, 2, 0), (5, 2, 0))]
        found = gltf.triangles()
        mirrored = matrix_rows((0, -1, 0, 0, 2, 0, 0, 0, 0, 0, -3, 0))
        self.expect_triangles(found[:2], quad)
        self.expect_triangles(found[-2:], [tuple(apply(mirrored, corner) for corner in each) for each in quad])
        corners = {corner for triangle in found[2:-2] for corner in triangle}
        self.assertEqual(len(found), 2 + 12 + 2)
        self.assertEqual(corners, {(10 + x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)})

    def test_the_faces_of_a_box_look_outwards(self):
        capture = Capture(self.folder)
        capture.build(1, capture.boxes([(-1, -2, -3, 1, 2, 3)]))
        volume = 0
        for (ax, ay, az), (bx, by, bz), (cx, cy, cz) in self.export(capture).triangles():
            volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6
        self.assertAlmostEqual(abs(volume), 48)

    def test_formats(self):
        half = [struct.unpack("<H", struct.pack("<e", value))[0] for value in (0, 1, -2.5, 0.25, 65504, 3)]
        for name, descr, code, rows, expected in (
                ("R32G32_SFLOAT", "<f4", "f", [(0, 0), (2, 1), (3, 5)], [(0, 0, 0), (2, 1, 0), (3, 5, 0)]),
                ("R32G32B32A32_SFLOAT", "<f4", "f", [(0, 0, 0, 9), (2, 1, 4, 9), (3, 5, 6, 9)],
                 [(0, 0, 0), (2, 1, 4), (3, 5, 6)]),
                ("R16G16_SFLOAT", "<f2", "H", [half[0:2], half[2:4], half[4:6]],
                 [(0, 1, 0), (-2.5, .25, 0), (65504, 3, 0)]),
                ("R16G16B16A16_SNORM", "<i2", "h", [(0, 32767, -32768, 1), (0, 0, 0, 1), (1, 0, 0, 1)],
                 [(0, 1, -1), (0, 0, 0), (1 / 32767, 0, 0)]),
                ("R16G16_UNORM", "<u2", "H", [(0, 65535), (0, 0), (1, 0)], [(0, 1, 0), (0, 0, 0), (1 / 65535, 0, 0)]),
                ("R8G8B8A8_SNORM", "|i1", "b", [(0, 127, -128, 1), (0, 0, 0, 1), (1, 0, 0, 1)],
                 [(0, 1, -1), (0, 0, 0), (1 / 127, 0, 0)]),
                ("R8G8B8A8_UNORM", "|u1", "B", [(0, 255, 51, 1), (0, 0, 0, 1), (1, 0, 0, 1)],
                 [(0, 1, .2), (0, 0, 0), (1 / 255, 0, 0)]),
                ("A2B10G10R10_UNORM_PACK32", "|u1", "B", [(255, 3, 0, 0), (0, 0, 0, 0), (0, 252, 15, 0)],
                 [(1, 0, 0), (0, 0, 0), (0, 1, 0)])):
            with self.subTest(name):
                self.begin_again()
                capture = Capture(self.folder)
                capture.build(1, capture.triangles(rows, descr=descr, code=code, vertex_format=f"VK_FORMAT_{name}"))
                self.expect_triangles(self.export(capture).triangles(), [tuple(expected)], 1e-6)

    def test_other_formats_and_geometries_are_counted(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles(TRIANGLE, vertex_format="VK_FORMAT_R64G64B64_SFLOAT"),
                      capture.triangles(TRIANGLE, vertex_format="VK_FORMAT_R32G32B32A32_SINT"),
                      capture.triangles([(0, 0)] * 3), {"type": "spheres", "primitiveCount": 7},
                      {"type": "triangles", "vertexFormat": 1234567, "primitiveCount": 7})
        gltf = self.export(capture)
        self.assertEqual(gltf.left_out(), {"geometries of other types or formats": 5})
        self.assertEqual(gltf.triangles(), [])
        self.assertNotIn("meshes", gltf.root)

    def test_offsets(self):
        """firstVertex, primitiveOffset, stride, and an array that begins behind its address."""
        corners = [(i, i * i, 0) for i in range(6)]
        for members, first, expected in (
                ({"firstVertex": 1, "primitiveCount": 1}, 0, [corners[1:4]]),
                ({"primitiveOffset": 24, "primitiveCount": 1}, 0, [corners[2:5]]),
                ({"firstVertex": 3, "primitiveOffset": 12, "primitiveCount": 1}, 36, [corners[1:4]]),
                ({"primitiveCount": 3}, 0, [corners[0:3], corners[3:6]])):
            with self.subTest(members):
                self.begin_again()
                capture = Capture(self.folder)
                capture.build(1, capture.triangles(corners, vertices_more={"first": first}, **members))
                gltf = self.export(capture)
                self.expect_triangles(gltf.triangles(), expected)
                self.assertEqual(gltf.left_out(), {"primitives whose data is not in the capture": 1}
                                 if members["primitiveCount"] > 1 else {})

    def test_indices_with_offsets(self):
        capture = Capture(self.folder)
        corners = [(i, i * i, 0) for i in range(6)]
        capture.build(1, capture.triangles(corners, [0, 1, 2, 2, 1, 0, 3, 4, 9], firstVertex=2,
                                           vertices_more={"first": 24}))
        gltf = self.export(capture)
        self.expect_triangles(gltf.triangles(), [corners[0:3], corners[2::-1]])
        self.assertEqual(gltf.left_out(), {"primitives whose data is not in the capture": 1})
        self.assertEqual(gltf.root["accessors"][0]["count"], 3)  # only what triangles use

    def test_what_is_not_finite(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles(TRIANGLE + [(0, math.inf, 0), (0, 0, 0), (0, 1, 0)]),
                      capture.triangles([(3e38, 0, 0), (1, 0, 0), (0, 1, 0)],
                                        matrix=(10, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)),
                      capture.boxes([(0, 0, 0, math.inf, 1, 1)]))
        capture.build_top(2, [(IDENTITY, 1), ((NAN,) * 12, 1)])
        gltf = self.export(capture)
        self.assertEqual(gltf.left_out(), {"primitives and instances with infinite coordinates": 4})
        self.expect_triangles(gltf.triangles(), [TRIANGLE])

    def test_missing_data(self):
        capture = self.top()
        for line in capture.lines:
            if line["Type"] == "Build" and line["dst_id"] == 1:
                line["geometry"][0]["inputs"][0].pop("data")
                line["geometry"][0]["inputs"][0]["missing"] = "it could not be read"
        gltf = self.export(capture)
        self.assertEqual(gltf.left_out(), {"primitives whose data is not in the capture": 1})
        self.assertEqual(gltf.triangles(), [])

    def test_no_stride(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(1, 2, 3)], primitiveCount=4000000000, vertices_more={"stride": 0}))
        self.assertEqual(self.export(capture).left_out(), {"primitives whose data is not in the capture": 4000000000})


class Nodes(Export):
    def test_any_matrix(self):
        """Sheared, mirrored, flat and tiny ones, too: a node may need a second one."""
        generator = random.Random(1)
        matrices = [tuple(generator.choice((0, generator.uniform(-2, 2), generator.uniform(-1e-3, 1e-3)))
                          for _ in range(12)) for _ in range(300)]
        matrices += [(0,) * 12, (1, 1, 1, 0) * 3, (0, 0, 0, 1, 0, 5, 0, 0, 0, 0, 0, 0), (-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0)]
        capture = self.top(instances=[(matrix, 1) for matrix in matrices])
        gltf = self.export(capture, "--plain-nodes")
        rounded = [struct.unpack("<12f", struct.pack("<12f", *matrix)) for matrix in matrices]
        self.expect_triangles(gltf.triangles(),
                              [tuple(apply(matrix_rows(matrix), corner) for corner in TRIANGLE) for matrix in rounded])
        for node in gltf.root["nodes"]:
            self.assertAlmostEqual(sum(value * value for value in node["rotation"]), 1, 9)

    def test_instances_share_a_node(self):
        matrices = [(1, 0, 0, i, 0, 2, 0, 0, 0, 0, 1, 0) for i in range(150)] + [(1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)]
        expected = [tuple(apply(matrix_rows(matrix), corner) for corner in TRIANGLE) for matrix in matrices]
        capture = self.top(instances=[(matrix, 1) for matrix in matrices])
        gltf = self.export(capture)
        self.assertEqual(len(gltf.root["nodes"]), 3)  # the sheared one has two
        self.assertEqual(gltf.root["extensionsUsed"], ["EXT_mesh_gpu_instancing"])
        self.expect_triangles(gltf.triangles(), expected)
        gltf = self.export(capture, "--plain-nodes")
        self.assertEqual(len(gltf.root["nodes"]), 152)
        self.assertNotIn("extensionsUsed", gltf.root)
        self.expect_triangles(gltf.triangles(), expected)

    def test_motion(self):
        """The first matrix counts."""
        common = struct.pack("<IIQ", 5 | 0xff << 24, 0, 1)
        moved = struct.pack("<12f", 1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0)
        still = struct.pack("<II", 0, 0) + moved + common
        matrices = struct.pack("<II", 1, 0) + moved + bytes(48) + common
        # scale 2, a pivot that nothing turns around, a quarter turn around z, and a translation
        srt = struct.pack("<16f", 2, 0, 0, 0, 2, 0, 0, 2, 0, 0, 0, math.sqrt(.5), math.sqrt(.5), 7, 8, 9)
        turned = struct.pack("<II", 2, 0) + srt + srt + common
        unknown = struct.pack("<II", 3, 0)
        rows = [row + bytes(152 - len(row)) for row in (still, matrices, turned, unknown)]
        capture = self.top(instances=())
        name = capture.data("|u1", "(4, 152)", b"".join(rows))
        capture.build(2, {"type": "instances", "primitiveCount": 4, "inputs": [
            {"role": "instances", "count": 4, "stride": 152, "size": 152, "data": name}]}, kind="top level",
                      references=[{"reference": "0x1", "structure": 1}])
        gltf = self.export(capture)
        there = [(4, 0, 0), (5, 0, 0), (4, 1, 0)]
        self.expect_triangles(gltf.triangles(), [there, there, [(7, 8, 9), (7, 10, 9), (5, 8, 9)]])
        self.assertEqual(gltf.left_out(), {"instances that refer to no known structure": 1})
        self.assertEqual(gltf.nodes()[0]["extras"]["customIndex"], 5)

    def test_what_instances_refer_to(self):
        capture = self.top(instances=())
        capture.structure(3)
        capture.build_top(2, [(IDENTITY, 16), (IDENTITY, 17), (IDENTITY, 18), (IDENTITY, 19)], references=[
            {"reference": "0x13", "structure": 2}, {"reference": "0x12", "structure": 3},
            {"reference": "0x10", "structure": 1}, {"reference": "0x11", "structure": 1, "is_dead": True}])
        gltf = self.export(capture)
        self.assertEqual(gltf.left_out(), {"instances that refer to a destroyed structure": 1,
                                           "instances of structures whose build is not in the capture": 2})
        self.expect_triangles(gltf.triangles(), [TRIANGLE])


class States(Export):
    """Which build is in a structure, and which one is exported."""

    def setUp(self):
        super().setUp()
        self.capture = capture = Capture(self.folder)
        capture.structure(2, "top level", name="first")
        capture.structure(3, "top level", name="second")
        capture.structure(4)
        moved = [(x, y, 5) for x, y, _ in TRIANGLE]
        capture.build(1, capture.triangles(TRIANGLE), frame=1)
        capture.build_top(2, [(IDENTITY, 1)], frame=1, region="frame 1::shadows")
        capture.command("Copy", mode="clone", src_id=1, dst_id=4, frame=2)
        capture.build(1, capture.triangles(moved), mode="update", src_id=1, frame=2)
        capture.build_top(3, [(IDENTITY, 1), (IDENTITY, 4)], frame=2, region="frame 2")
        capture.command("Destroyed", dst_id=1)
        self.old, self.new = TRIANGLE, moved

    def test_points(self):
        for options, expected in (
                ([], [self.old, self.new]), (["--at", "frame:1"], [self.old]), (["--at", "frame:7"], [self.old, self.new]),
                (["--at", "submission:2"], [self.old]), (["--at", "build:4"], [self.new]),
                (["--at", "label:shadows"], [self.old]), (["--at", "label:frame"], [self.old, self.new]),
                (["--tlas", "first"], [self.new]), (["--tlas", "3", "--at", "build:5"], [self.old, self.new]),
                (["--tlas", "1"], [self.new]), (["--tlas", "4"], [self.old]), (["--at", "build:1"], [self.old])):
            with self.subTest(options):
                self.expect_triangles(self.export(self.capture, *options).triangles(), expected)

    def test_wrong_points(self):
        self.capture.write()
        for options, says in (
                (["--at", "7"], "not frame:N, submission:N, build:N or label:TEXT: 7"),
                (["--at", "frame:"], "not frame:N"), (["--at", "frame:x"], "not frame:N"),
                (["--at", "build:1x"], "not frame:N"), (["--at", "line:1"], "not frame:N"),
                (["--at", "submission:99"], "submission:99: nothing was executed there"),
                (["--at", "label:none"], "label:none: nothing was executed there"), (["--at"], "an option needs a value: --at"),
                (["--tlas", "nobody"], "nobody: no structure with that name or id had been built by then"),
                (["--tlas", "second", "--at", "build:1"], "second: no structure with that name")):
            status, out, err = run("export", self.folder, self.file, *options)
            self.assertEqual((status, out), (2, ""))
            self.assertTrue(err.startswith(f"assay-scene: {says}"), err)
            self.assertFalse(self.file.exists())

    def test_a_file_that_cannot_be_written(self):
        self.capture.write()
        status, _, err = run("export", self.folder, self.folder)
        self.assertEqual((status, err), (2, f"assay-scene: {self.folder}: cannot be written\n"))


class Colors(Export):
    def colors(self, gltf):
        return [gltf.root["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
                for node in gltf.nodes() for _, mesh in gltf.placements(node) for primitive in mesh["primitives"]]

    def test_structures_and_flags(self):
        capture = Capture(self.folder)
        for number in (1, 2):
            capture.structure(number)
            capture.build(number, capture.triangles(TRIANGLE), capture.triangles(TRIANGLE, flags="0x0"))
        colors = self.colors(self.export(capture))
        self.assertEqual((colors[0], colors[2]), (colors[1], colors[3]))
        self.assertNotEqual(colors[0], colors[2])
        self.assertEqual(self.colors(self.export(capture, "--color", "structure")), colors)
        gltf = self.export(capture, "--color", "flags")
        colors = self.colors(gltf)
        self.assertEqual((colors[0], colors[1]), (colors[2], colors[3]))
        self.assertNotEqual(colors[0], colors[1])
        self.assertEqual([material["name"] for material in gltf.root["materials"]], ["finding", "opaque", "not opaque"])

    def test_findings(self):
        capture = Capture(self.folder)
        build = capture.build(1, capture.triangles(TRIANGLE * 3), capture.boxes([(0, 0, 0, 1, 1, 1)] * 2),
                              capture.triangles(TRIANGLE))
        top = capture.build_top(2, [(IDENTITY, 1)] * 3)
        place = "pInfos[0].pGeometries[{}].geometry"
        capture.finding(build, place.format(0), "has index 5 of primitive 1 is vertex 9")
        capture.finding(build, place.format(1), "leads to primitive 1, whose minX 2 is not ...", "VUID-c-d")
        capture.finding(build, place.format(2), "is about all of it")
        capture.finding(top, place.format(0), "leads to instance 2, whose transform is not invertible")
        capture.finding(top + 7, place.format(0), "leads to instance 1, but in another submission")
        gltf = self.export(capture)
        red = {(primitive["extras"]["geometry"], corners) for node in gltf.nodes()[:1]
               for _, mesh in gltf.placements(node) for corners, primitive in gltf.mesh_triangles(mesh)
               if primitive["material"] == 0}
        self.assertEqual(len([each for each in red if each[0] == 1]), 12)
        self.assertEqual({each[0] for each in red}, {0, 1, 2})
        mesh = gltf.root["meshes"][gltf.nodes()[0]["mesh"]]
        self.assertEqual([(primitive["extras"]["geometry"], primitive["material"] == 0,
                           gltf.root["accessors"][primitive["indices"]]["count"]) for primitive in mesh["primitives"]],
                         [(0, False, 6), (0, True, 3), (1, False, 36), (1, True, 36), (2, True, 3)])
        self.assertEqual(mesh["primitives"][3]["extras"]["findings"], [
            {"id": "VUID-c-d", "primitive": 1, "message": "leads to primitive 1, whose minX 2 is not ..."}])
        self.assertEqual([each["id"] for each in mesh["extras"]["findings"]], ["VUID-a-b", "VUID-c-d", "VUID-a-b"])
        self.assertEqual(len(gltf.root["scenes"][0]["extras"]["findings"]), 1)
        self.assertNotIn("findings", mesh["primitives"][2]["extras"])
        self.assertNotIn("findings", gltf.nodes()[1]["extras"])
        self.assertEqual(gltf.nodes()[2]["extras"]["findings"][0]["id"], "VUID-a-b")
        other = gltf.root["meshes"][gltf.nodes()[2]["mesh"]]
        self.assertEqual({primitive["material"] for primitive in other["primitives"]}, {0})
        self.assertEqual(gltf.root["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], RED)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
