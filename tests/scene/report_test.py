# SPDX-License-Identifier: Apache-2.0
"""assay-scene report, on captures that the tests make.

usage: report_test.py ASSAY_SCENE [CASE...]"""

import json
import math
import pathlib
import struct
import sys
import unittest

sys.path.insert(1, str(pathlib.Path(__file__).resolve().parent.parent / "assay_run"))
# pylint: disable=wrong-import-position
from browser import CHROMIUM, OfPages
from captures import IDENTITY, NAN, Capture, Case, run, scene

INF = float("inf")
UNIT = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


def without_times(value):
    """The figures that are the same in each run."""
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key.split()[0] not in ("ns", "us", "ms")}
    return [without_times(item) for item in value] if isinstance(value, list) else value


def grid(side, height=lambda x, y: 0):
    """Vertices of the triangles of side * side squares."""
    def corner(x, y):
        return (x, y, height(x, y))
    return [at for x in range(side) for y in range(side)
            for at in (corner(x, y), corner(x + 1, y), corner(x + 1, y + 1),
                       corner(x, y), corner(x + 1, y + 1), corner(x, y + 1))]


class ReportCase(Case):
    def setUp(self):
        super().setUp()
        self.json, self.html = self.place / "report.json", self.place / "report.html"

    def report(self, capture, *options):
        capture.write()
        status, out, err = run("report", self.folder, "--json", self.json, "--rays", 100, "--device", "none", *options)
        self.assertEqual((status, out), (0, ""), err)
        self.assertIn("assay-scene: accuracy in time, quality balanced\n", err)
        return json.loads(self.json.read_text("utf-8"))

    def rows(self, report, kind):
        return [row for row in report["fragile"]["rows"] if row["kind"] == kind]


class Accuracy(ReportCase):
    def test_rows(self):
        report = self.report(scene(self.folder))
        rows = report["accuracy"]["rows"]
        sets = [each["rays"] for each in report["accuracy"]["sets"]]
        self.assertEqual(sets, ["camera", "random", "surface", "axis", "edges", "vertices", "grazing", "far origin"])
        self.assertEqual([(row["quality"], row["accuracy"], row["set"]) for row in rows],
                         [(quality, accuracy, each) for quality in ("fast", "balanced", "high")
                          for accuracy in ("fast", "robust", "exact") for each in sets])
        for row in rows:
            self.assertGreater(row["ns a ray"], 0)
            self.assertEqual(row["rays"], 100)
            if row["accuracy"] == "exact":
                self.assertEqual((row["wrong"], row["missed"], row["double"], row["nearest"]), (0, 0, 0, 0))
        self.assertEqual(report["subject"]["structures"], 2)
        self.assertEqual(report["subject"]["top level"], "world")
        self.assertEqual(report["subject"]["left out"], {"instances that refer to no known structure": 1,
                                                         "instances without a structure": 1})

    def test_edges_cost_misses(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles(grid(20, lambda x, y: math.sin(x * 1.1) * math.cos(y * 0.7))))
        rows = self.report(capture, "--rays", 3000)["accuracy"]["rows"]
        wrong = {(row["accuracy"], row["set"]): row["wrong"] for row in rows if row["quality"] == "balanced"}
        self.assertGreater(wrong["fast", "edges"], 100000)
        self.assertGreater(wrong["robust", "vertices"], 10000)
        self.assertLess(wrong["robust", "camera"], 1000)

    def test_same_figures(self):
        capture = scene(self.folder)
        first = without_times(self.report(capture))
        self.assertEqual(first, without_times(self.report(capture)))

    def test_camera_and_top(self):
        report = self.report(scene(self.folder), "--camera", "1,2,30,1,2,0", "--tlas", "boxes", "--at", "frame:1")
        self.assertEqual(report["subject"]["camera"], [1, 2, 30, 1, 2, 29])
        self.assertEqual(report["subject"]["top level"], "boxes")
        self.assertEqual(report["subject"]["at"], "frame:1")

    def test_arguments(self):
        capture = scene(self.folder)
        capture.write()
        for words, says in ((["report", self.folder], "name a file to write"),
                            (["report", self.folder, "--json"], "needs a value: --json"),
                            (["report", self.folder, "--json", self.json, "--camera", "1,2,3"], "1,2,3"),
                            (["report", self.folder, "--json", self.json, "--rays", "0"], "not a value"),
                            (["report", self.folder, "--json", "/nonexistent/x"], "/nonexistent/x: No such file"),
                            (["report", self.folder, "--json", self.json, "--tlas", "?"], "no structure with that name"),
                            (["report", "/nonexistent", "--json", self.json], "/nonexistent/builds.jsonl")):
            status, _, err = run(*words)
            self.assertEqual(status, 2, words)
            self.assertIn(says, err)

    def test_nothing_to_trace(self):
        capture = Capture(self.folder)
        capture.build(1, {"type": "spheres"})
        capture.write()
        status, _, err = run("report", self.folder, "--json", self.json)
        self.assertEqual(status, 2)
        self.assertIn("the scene has no triangle and no AABB whose data is in the capture", err)


class Effects(ReportCase):
    def test_costs(self):
        capture = Capture(self.folder)
        hills = grid(12)
        moved = [(x, y, 5 * math.sin(x * 7 + y * 3)) for x, y, _ in hills]
        capture.build(1, capture.triangles(hills, flags="0x0"), flags=1)
        capture.build(1, capture.triangles(moved, flags="0x0"), mode="update", src_id=1, flags=1, frame=2)
        capture.build_top(2, [(IDENTITY, 1)])
        report = self.report(capture)
        self.assertGreater(report["scene"]["any-hit invocations a ray"], 0)
        cost = {effect["effect"]: effect.get("cost") for effect in report["effects"]}["updates"]
        self.assertEqual(cost["structures"], 1)
        for way in ("with", "without"):
            self.assertGreater(cost[way]["nodes a ray"], 0)
        points = report["waste"]["refits"][0]["points"]
        self.assertEqual([point["frame"] for point in points], [0, 2])
        self.assertEqual(points[0]["sah"], points[0]["rebuilt"])
        self.assertGreater(points[1]["sah"], points[1]["rebuilt"])

    def test_motion(self):
        """Triangles that move, and an instance between two matrices."""
        capture = Capture(self.folder)
        capture.structure(1, name="moving")
        capture.structure(2, "top level", name="world")
        hills = grid(6)
        mesh = capture.triangles(hills)
        mesh["inputs"].append(capture.rows("motion vertices", "<f4", "f", [(x, y, z + 9) for x, y, z in hills]))
        capture.build(1, mesh, flags=0x20)
        moved = [*IDENTITY[:3], 30, *IDENTITY[4:]]
        row = struct.pack("<II12f12fIIQ", 1, 0, *IDENTITY, *moved, 255 << 24, 0, 1).ljust(152, b"\0")
        capture.build(2, {"type": "instances", "flags": "0x0", "primitiveCount": 1, "inputs": [
            {"role": "instances", "address": "0x20000", "buffer": 1, "offset": 0, "count": 1, "stride": 160, "size": 152,
             "data": capture.data("|u1", "(1, 152)", row)}]}, kind="top level", flags=0x20,
            references=[{"reference": "0x1", "structure": 1}])
        report = self.report(capture)
        cost = {effect["effect"]: effect.get("cost") for effect in report["effects"]}["builds with motion"]
        self.assertGreater(cost["with"]["bytes"], cost["without"]["bytes"])
        self.assertGreater(cost["with"]["nodes a ray"], 0)
        self.assertEqual({row["name"] for row in self.rows(report, "motion")}, {"moving", "world"})
        status, _, err = run("report", self.folder, "--json", self.json, "--rays", 10)
        self.assertEqual(status, 0, err)
        self.assertEqual(json.loads(self.json.read_text("utf-8"))["device"]["missing"], "Motion is not built on a device.")

    def test_advice(self):
        capture = scene(self.folder)
        capture.finding(1, "pInfos[0]", "this is advice", vuid="ASSAY-advice-something")
        capture.finding(1, "pInfos[0]", "this is none")
        self.assertEqual(self.report(capture)["waste"]["advice"],
                         [{"id": "ASSAY-advice-something", "message": "this is advice"}])


class Fragile(ReportCase):
    def fragile(self, *geometry, **members):
        capture = Capture(self.folder)
        capture.structure(1, name="mesh")
        capture.structure(2, "top level", name="world")
        capture.build(1, *(geometry[0](capture) if callable(geometry[0]) else geometry), **members)
        capture.build_top(2, [(IDENTITY, 1)])
        return self.report(capture)

    def expect(self, kind, make, primitives, geometry=0):
        report = self.fragile(lambda capture: [capture.triangles(UNIT)] * geometry + [make(capture)])
        row = self.rows(report, kind)[0]
        self.assertEqual((row["structure"], row["name"], row["geometry"], row["primitives"]),
                         (1, "mesh", geometry, primitives), kind)
        return row

    def test_triangles(self):
        good = grid(2)
        for kind, triangle in {
                "inactive": [(NAN, 0, 0), (1, 0, 0), (0, 1, 0)],
                "NaN in Y or Z": [(0, 0, NAN), (1, 0, 0), (0, 1, 0)],
                "two corners at one position": [(0, 0, 0), (0, 0, 0), (0, 1, 0)],
                "corners on one line": [(0, 0, 0), (1, 2, 3), (2, 4, 6), (0, 0, 0), (1, 0, 0), (2, 0, 0)],
                "sliver": [(0, 0, 0), (1, 0, 0), (0.5, 1e-6, 0)],
                "area that is 0 in float": [(0, 0, 0), (1e-23, 0, 0), (0, 1e-23, 0)],
                "products of coordinates underflow": [(0, 0, 0), (1e-23, 0, 0), (0, 1e-23, 0)],
                "products of coordinates overflow": [(0, 0, 0), (1e20, 0, 0), (0, 1e20, 0)],
                "far from the origin": [(1e6, 0, 0), (1e6 + 1, 0, 0), (1e6, 1, 0)]}.items():
            with self.subTest(kind):
                self.folder = self.folder.parent / kind
                self.expect(kind, lambda capture, t=triangle: capture.triangles(good + t), [8, 9][:len(triangle) // 3], geometry=1)

    def test_sliver_causes_wrong_rays(self):
        row = self.expect("sliver", lambda capture: capture.triangles(
            [(0.1, 0.3, 0.7), (1e3, 700.7, 333.3), (500.05001, 350.50001, 166.99999)]), [0])
        self.assertGreater(row["robust"]["wrong"], 1000)
        self.assertGreater(row["figure"], 1e4)

    def test_neighbours(self):
        square = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 0, 0), (2, 2, 0), (0, 2, 0)]
        halves = [(2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 1, 0), (3, 2, 0), (2, 2, 0)]
        row = self.expect("T-junction", lambda capture: capture.triangles(square + halves), [0])
        self.assertEqual(row["figure"], 0)
        self.folder = self.folder.parent / "crack"
        torn = [(2.0001, 0, 0), (4, 0, 0), (2, 2.0001, 0)]
        row = self.rows(self.fragile(lambda capture: [capture.triangles(square + torn)]), "crack")[0]
        self.assertEqual(sorted(row["primitives"]), [0, 1, 2])
        self.assertAlmostEqual(row["figure"], 5e-5, 6)
        self.folder = self.folder.parent / "coincident"
        self.expect("coincident triangles", lambda capture: capture.triangles(square + square[3:] + square[:3]), [2, 3])
        self.folder = self.folder.parent / "outlier"
        self.expect("outlier", lambda capture: capture.triangles(grid(4) + [(1e7, 0, 0), (1e7, 9, 0), (1e7, 0, 9)]), [32])

    def test_closed_mesh_has_no_open_edge(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        faces = [corners[i] for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)) for i in face]
        report = self.fragile(lambda capture: [capture.triangles(faces)])
        self.assertEqual([row["kind"] for row in report["fragile"]["rows"]], ["shared edges"])

    def test_boxes(self):
        boxes = [(0, 0, 0, 1, 2, 3), (1, 0, 0, 0, 1, 1), (2, 2, 2, 2, 2, 2), (-INF, 0, 0, INF, 1, 1), (NAN, 0, 0, 1, 1, 1)]
        report = self.fragile(lambda capture: [capture.boxes(boxes)])
        for kind, primitive in (("minimum above maximum", 1), ("box without extent", 2), ("infinite box", 3),
                                ("inactive", 4)):
            self.assertEqual(self.rows(report, kind)[0]["primitives"], [primitive])

    def test_instances(self):
        capture = Capture(self.folder)
        capture.structure(1, name="mesh")
        capture.structure(2, name="nothing")
        capture.structure(3, "top level", name="world")
        capture.build(1, capture.triangles(grid(3)))
        capture.build(2, capture.triangles([(NAN, 0, 0)] * 3))
        scaled = [[a, 0, 0, x, 0, b, 0, 0, 0, 0, c, 0] for a, b, c, x in (
            (1, 1, 0, 0), (-1, 1, 1, 0), (1, 1, 1e-5, 0), (1, 1, 1, 1e7), (NAN, 1, 1, 0))]
        capture.build_top(3, [*((matrix, 1) for matrix in scaled), (IDENTITY, 0), (IDENTITY, 1, 0, 0), (IDENTITY, 2)])
        report = self.report(capture)
        for kind, instance in (("singular transform", 0), ("mirrored transform", 1), ("ill-scaled transform", 2),
                               ("far from the origin", 3), ("mask 0", 6)):
            row = self.rows(report, kind)[0]
            self.assertEqual((row["structure"], row["instances"]), (3, [instance]), kind)
        self.assertIn("nothing", [row["name"] for row in self.rows(report, "nothing active")])

    def test_layout_of_the_capture(self):
        """The report reads positions as floats, and still knows the format, the fourth component and offsets."""
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(x, y, z, 0) for x, y, z in UNIT], descr="<f2", code="e",
                                           vertex_format="VK_FORMAT_R16G16B16A16_SFLOAT"),
                      capture.triangles(UNIT * 3, firstVertex=3),
                      {"type": "spheres", "inputs": [{"role": "opacity indices", "missing": "why"}]})
        report = self.report(capture)
        self.assertEqual(self.rows(report, "positions of 16 bits or fewer")[0]["geometry"], 0)
        self.assertEqual(self.rows(report, "fourth component")[0]["geometry"], 0)
        self.assertEqual(self.rows(report, "offsets in the build range")[0]["geometry"], 1)
        self.assertEqual([self.rows(report, kind)[0]["geometry"] for kind in ("spheres", "opacity micromaps")], [2, 2])
        self.assertEqual(report["subject"]["left out"]["geometries of other types or formats"], 1)

    def test_missing_vertices_are_not_inactive(self):
        report = self.fragile(lambda capture: [capture.triangles(UNIT, indices=[0, 1, 2, 0, 1, 9])])
        self.assertEqual(self.rows(report, "inactive"), [])
        self.assertEqual(self.rows(report, "index out of range")[0]["primitives"], [1])
        self.assertEqual(report["subject"]["left out"], {"primitives whose data is not in the capture": 1})


@unittest.skipUnless(CHROMIUM, "Chromium is not installed")
class Page(OfPages, ReportCase):
    def open(self, capture, width=1280):
        self.report(capture, "--html", self.html)
        self.assertLess(self.html.stat().st_size, 5 << 20)
        self.browser.open(self.html, width)

    def count(self, selector):
        return self.browser.run(f"document.querySelectorAll({selector!r}).length")

    def test_page(self):
        capture = scene(self.folder)
        capture.build(1, capture.triangles(grid(3), flags="0x0"), mode="update", src_id=1, flags=3, frame=3)
        capture.lines[-1]["application"] = "</script><b>"
        capture.finding(1, "pInfos[0]", "</script><b>advice</b>", vuid="ASSAY-advice-something")
        for width in (1280, 800):
            with self.subTest(width):
                self.open(capture, width)
                self.assertEqual(self.count("#canvases canvas"), 4)
                self.assertEqual(self.count("#charts svg"), 8)
                self.assertEqual(self.count("#rows tbody tr"), 24)
                self.assertEqual(self.count("#refits svg"), 1)
                self.assertEqual(self.browser.run("document.querySelector('#advice').innerText"),
                                 "</script><b>advice</b> (ASSAY-advice-something)")
                self.assertIn("--device none", self.browser.run("document.querySelector('#of-device').innerText"))
                self.assertFalse(self.browser.run("document.documentElement.scrollWidth > window.innerWidth"))
        self.browser.run("quality.value = 'high'; quality.dispatchEvent(new Event('change'))")
        self.assertIn("quality high", self.browser.run("document.querySelector('#charts svg').getAttribute('aria-label')"))

    def test_what_pixels_show(self):
        """A square in front of the camera: half of the picture is it, and a hit is one test or two. A ray that passes a
        triangle in front of it within that triangle's box has one test more."""
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(-1, -9, 0), (1, -9, 0), (1, 9, 0), (-1, -9, 0), (1, 9, 0), (-1, 9, 0)]))
        capture.build(2, capture.triangles([(-1, -9, 0.5), (1, -9, 0.5), (1, 0, 0.5)]))
        report = self.report(capture, "--html", self.html, "--camera", "0,0,3.4286,0,0,0")["pictures"]
        self.assertEqual((report["width"], report["height"], report["most primitives"]), (640, 400, 3))
        self.assertAlmostEqual(report["primitives a pixel"], 1.3, 1)
        self.assertEqual(report["most nodes"], 3)  # of the top-level structure, of the square, and of the triangle
        self.assertLess(report["pixels wrong at robust"], 10)  # at the diagonal


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
