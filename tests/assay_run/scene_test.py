# SPDX-License-Identifier: Apache-2.0
"""The 3D view on the page of --html, in headless Chromium, of captures that the tests write.

scene_test.py ASSAY_SCENE PROGRAMS_TEST LAYERS"""

import base64
import json
import os
import pathlib
import struct
import sys
import unittest

from browser import CHROMIUM, OfPages
from runs import NASTY, ROOT, Runs, finding, header, main

sys.path.insert(0, str(ROOT / "tests/scene"))

# pylint: disable=wrong-import-position
from captures import IDENTITY, NAN, Capture
from assay_run.page import write_page
from assay_run.records import read_records
from assay_run.scene import Scene, find_three
from assay_run.verdict import Verdict

ASSAY_SCENE, PROGRAMS, LAYERS = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
QUAD = [0, 1, 2, 0, 2, 3]
ODD = NASTY.replace("\0", "")  # names are strings of C
NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null"


def at(x, scale=1):
    return (scale, 0, 0, x, 0, scale, 0, 0, 0, 0, scale, 0)


def place(build, **members):
    """Where tests' captures have their builds."""
    return {"device": "0xde", "queue": "0x9", "submission": build, "build": 0, **members,
            "Objects": [{"type": "VkCommandBuffer", "handle": "0xcb"}, *members.get("Objects", [])]}


class Case(Runs):
    def capture(self):
        capture = Capture(self.folder / "capture")
        for number, name in ((1, "quad"), (2, "boxes"), (3, ODD)):
            capture.structure(number, name=name)
        capture.structure(4, "top level", name="world")
        return capture

    def write(self, capture, *lines, **members):
        """Writes the page of a capture, and of a record of the same process."""
        capture.write()
        record = self.write_record(header(), *lines)
        (self.folder / "work").mkdir(exist_ok=True)
        scene = Scene(self.folder / "work", os.environ)
        for name, value in {"program": ASSAY_SCENE, "is_wanted": True, "capture": str(capture.folder), **members}.items():
            setattr(scene, name, value)
        found = read_records([record])
        write_page(self.folder / "a.html", Verdict(found, found.mistakes(), []), ["app"], scene)


@unittest.skipUnless(CHROMIUM and find_three(os.environ), "Chromium or libjs-three is not installed")
class View(OfPages, Case):
    def open(self, *arguments, **members):
        self.write(*arguments, **members)
        self.browser.open(self.folder / "a.html", 640)

    def text(self, name):
        return self.browser.run(f"document.getElementById('scene-{name}').textContent")

    def choose(self, name, value):
        self.browser.run(f"get('scene-{name}').value = {value}; "
                         f"get('scene-{name}').dispatchEvent(new Event('input'))")

    def pixels(self, condition):
        """How many pixels of the picture have a color."""
        return self.browser.run(f"""(() => {{
            const gl = scene.renderer.getContext();
            const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
            draw();
            gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
            let count = 0;
            for (let i = 0; i < pixels.length; i += 4) {{
                const [r, g, b, a] = pixels.subarray(i, i + 4);
                count += a > 200 && ({condition});
            }}
            return count;
        }})()""")

    def red_pixels(self):
        return self.pixels("r > 2 * g && r > 2 * b")

    def click(self):
        """In the middle of the picture."""
        x, y = self.browser.run("(() => { const box = get('scene-canvas').getBoundingClientRect();"
                                "return [box.x + box.width / 2, box.y + box.height / 2]; })()")
        for kind in ("mousePressed", "mouseReleased"):
            self.browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def test_findings(self):
        """A triangle, an instance and a whole structure are red; links lead to them, and back."""
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD), frame=1)
        capture.build(2, capture.boxes([(0, 0, 0, 1, 1, 1)] * 2), frame=1)
        capture.build(3, capture.triangles(CORNERS, QUAD), frame=1)
        capture.build_top(4, [(IDENTITY, 1), (at(3), 2, 7, 0x81, 3, 1), (at(6), 2)], frame=2)
        self.open(capture,
                  finding("VUID-triangle", MainMessage="pInfos[0] primitive 1 is bad.", **place(1),
                          Location="pInfos[0].pGeometries[0].geometry.triangles"),
                  finding("VUID-instance", MainMessage="The instance 2 is bad.", **place(4)),
                  finding("VUID-whole", MainMessage=ODD, **place(3)),
                  finding("VUID-other", Objects=[{"type": "VkAccelerationStructureKHR", "handle": "0x1002"}]))
        self.assertIn("1 of 1: “world” after the build in submission 4, frame 2 (command 4 of the capture): "
                      "3 instances of 2 structures, 6 primitives, 2 findings.", self.text("summary"))
        self.assertIn("what findings are about (2)", self.text("legend"))
        links = self.browser.run("[...document.querySelectorAll('#groups .link')].map(link => link.textContent)"
                                 ".filter(text => text.includes('show'))")
        self.assertEqual(sorted(links), 3 * ["show in the scene"] + ["show the structure in the scene"])
        self.assertGreater(self.red_pixels(), 100)
        for vuid, shown in (("VUID-triangle", "geometry 0, opaque: triangle 1"),
                            ("VUID-instance", "instance 2 of “world”"), ("VUID-whole", "</script>"),
                            ("VUID-other", "instance 1 of “world”: custom index 7, mask 0x81, offset 3, "
                                           "TRIANGLE_FACING_CULL_DISABLE")):
            self.browser.run(f"[...document.querySelectorAll('.group')].find(group => group.textContent.startsWith("
                             f"{vuid!r})).querySelector('.finding li:last-child .link').click()")
            self.assertIn(shown, self.text("object"))
            if vuid != "VUID-other":
                self.assertIn("1 finding" + vuid, self.text("object"))
                self.assertGreater(self.red_pixels(), 5000)
        self.browser.run("get('scene-next').click(); document.querySelector('#scene-object ul:last-child .link').click()")
        self.assertIn("pInfos[0] primitive 1 is bad.", self.browser.run("document.activeElement.textContent"))

    def test_left_out(self):
        """What is inactive, null, unknown, not finite or not in the capture is neither drawn nor forgotten."""
        capture = self.capture()
        capture.build(1, capture.triangles([*CORNERS, (NAN, 0, 0)], [*QUAD, 0, 1, 4, 0, 1, 99]))
        capture.build(2, capture.boxes([(NAN, 0, 0, 1, 1, 1)]))
        capture.build(3, capture.triangles([(1e30, 0, 0), (5e30, 0, 0), (1e30, 2e30, 0), (5e30, 2e30, 0)], [0, 1, 2, 1, 2, 3]))
        capture.build_top(4, [(IDENTITY, 1), (at(2), 1), (IDENTITY, 0), (IDENTITY, 99), (IDENTITY, 2), (IDENTITY, 3)])
        capture.add("End", why="capture_limit_mib was reached")
        self.open(capture, finding("VUID-null", MainMessage="The instance 2 refers to nothing.", **place(4)),
                  finding("VUID-inactive", MainMessage="pInfos[0] primitive 0 is bad.", **place(2),
                          Location="pInfos[0].pGeometries[0].geometry.aabbs"))
        notes = self.text("notes")
        for note in ("inactive primitives: 2.", "primitives whose data is not in the capture: 1.",
                     "instances without a structure: 1.", "instances that refer to no known structure: 1.",
                     "instances of structures in which nothing is active: 1.",
                     "instances too far away to be drawn beside the others: 1.",
                     "The capture ends early: capture_limit_mib was reached."):
            self.assertIn(note, notes)
        self.assertIn("2 instances of", self.text("summary"))
        for shown in ("", "“boxes”instance 4 of “world”"):
            self.browser.run("get('scene-next').click()")
            self.assertIn("What the finding is about cannot be drawn", self.text("object"))
            self.assertIn(shown, self.text("object"))
        self.browser.run("lookAtWhole()")
        near = self.pixels("true")
        self.assertGreater(near, 5000)
        self.browser.run("get('scene-whole').click()")
        self.assertIn("3 instances of", self.text("summary"))
        self.assertGreater(self.pixels("true"), 5000)
        self.browser.run("lookAt([scene.items[2].box])")
        self.click()
        self.assertIn("instance 5 of “world”", self.text("object"))
        self.assertIn("\\</script>", self.text("object"))

    def test_moments_and_colors(self):
        capture = self.capture()
        capture.structure(5, "top level", name="shadows")
        capture.build(1, capture.triangles(CORNERS, QUAD), flags=1, frame=1)
        for frame in (1, 5):
            capture.build(2, capture.triangles(CORNERS, QUAD), mode="build" if frame == 1 else "update", frame=frame)
            capture.build_top(4, [(IDENTITY, 1), (at(2 * frame), 2)], frame=frame)
        capture.build_top(5, [(IDENTITY, 1)], frame=5)
        capture.build(3, capture.triangles(CORNERS, QUAD), frame=5)
        self.open(capture)
        self.assertEqual(self.browser.run("[...get('scene-structure').options].map(one => one.textContent)")[:2],
                         ["“shadows”", "“world”"])
        self.assertIn(", in no top-level structure", self.browser.run("get('scene-structure').textContent"))
        self.choose("structure", 1)
        self.assertIn("2 of 2: “world” after the build in submission 5, frame 5", self.text("summary"))
        self.choose("color", 2)
        self.assertIn("written in the same frame (1)", self.text("legend"))
        self.assertIn("written 2 to 9 frames before (1)", self.text("legend"))
        self.choose("moment", 0)
        self.assertIn("1 of 2", self.text("summary"))
        self.assertIn("written in the same frame (2)", self.text("legend"))
        self.choose("color", 1)
        self.assertIn("ALLOW_UPDATE (1)", self.text("legend"))
        self.choose("color", 3)  # all structures of these captures lie at one place
        self.assertIn("shares memory with another structure (2)", self.text("legend"))
        self.click()
        for drawing, least in ((1, 100), (2, 100), (0, 5000)):
            self.choose("draw", drawing)
            self.browser.run("lookAtWhole()")
            self.assertGreater(self.pixels("true"), least)
        self.assertEqual(self.browser.run("scene.items[0].box.max.y - scene.items[0].box.min.y > 0.1"), True)
        self.choose("up", 1)  # the quad lies now
        self.assertEqual(self.browser.run("scene.items[0].box.max.y - scene.items[0].box.min.y > 0.1"), False)
        self.choose("up", 0)
        self.browser.run("lookAt([scene.items[0].box])")
        self.click()
        self.assertIn("shares memory with “world”", self.text("object"))
        self.choose("draw", 2)
        self.click()
        self.assertIn("“quad”instance 0 of “world”", self.text("object"))

    def test_flat(self):
        """Transforms that have no inverse are drawn, and found by their boxes."""
        capture = self.capture()
        capture.build(1, capture.boxes([(0, 0, 0, 1, 1, 1)]))
        capture.build_top(4, [((1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0), 1)])
        self.open(capture)
        self.assertGreater(self.pixels("true"), 5000)
        self.click()
        self.assertIn("instance 0 of “world”", self.text("object"))

    def test_keyboard(self):
        """Keys zoom; the wheel does, too, once the picture is in use, and otherwise scrolls."""
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD))
        self.open(capture)
        self.assertIn("1 of 1: “quad” after the build", self.text("summary"))
        distance = "scene.camera.position.distanceTo(scene.controls.target)"
        before = self.browser.run(distance)
        self.assertFalse(self.browser.run("scene.controls.enableZoom"))
        self.browser.run("get('scene-canvas').focus()")
        self.assertTrue(self.browser.run("scene.controls.enableZoom"))
        self.browser.press("+", 0, "+")
        self.assertAlmostEqual(self.browser.run(distance), 0.8 * before, 5)
        self.assertEqual(self.browser.run("[...document.querySelectorAll('#scene-view :is(input, select, button, canvas)')]"
                                          ".filter(one => one.tabIndex < 0).length"), 0)

    def test_narrow(self):
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD))
        self.write(capture)
        self.browser.open(self.folder / "a.html", 400)
        self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), 400)

    def test_no_webgl(self):
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD))
        self.browser.call("Page.addScriptToEvaluateOnNewDocument", source=NO_WEBGL)
        self.open(capture, finding(**place(1)))
        self.assertEqual(self.text("why"), "There is no picture, because this browser has no WebGL.")
        self.assertTrue(self.browser.run("get('scene-view').hidden"))
        self.assertEqual(self.browser.run("document.querySelectorAll('.finding').length"), 1)

    def test_wrong_data(self):
        """The rest of the page is shown whatever happens to the picture."""
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD))
        self.write(capture, finding(**place(1)))
        page = self.folder / "a.html"
        page.write_text(self.read("a.html").replace('[{"rows":', '[{"rows":9'), encoding="utf-8")
        self.browser.open(page)
        self.assertIn("There is no picture, because of TypeError", self.text("why"))
        self.assertEqual(self.browser.run("document.querySelectorAll('.finding').length"), 1)
        self.assertNotEqual(self.browser.console, [])
        self.browser.console.clear()

    def test_no_builds(self):
        self.open(self.capture())
        self.assertIn("There is no picture, because the capture of this run has no build", self.text("why"))
        self.assertTrue(self.browser.run("get('scene-view').hidden"))


class Run(Case):
    """What assay-run tells the layer, and when the page has a view at all."""

    def page_data(self):
        return json.loads(self.read("a.html").partition('id="data">')[2].partition("</script>")[0])

    def run_html(self, *options, **environment):
        """Returns the settings that the application gets, and the page."""
        self.expect(self.run_script(
            "load(); end(); write_to = open('settings', 'w'); json.dump({key[20:]: value for key, value in "
            "os.environ.items() if key.startswith('VK_ASSAY_VALIDATION_')}, write_to)",
            "--html", "a.html", *options, **environment), 0)
        return self.load("settings"), self.read("a.html")

    def test_without_content(self):
        settings, page = self.run_html()
        self.assertNotIn("CAPTURE", settings)
        self.assertNotIn("scene-section", page)
        self.assertNotIn("three.js", page)
        self.assertLess(len(page), 70_000)

    def test_without_three(self):
        for options in (("--level", "content"), ("--everything",), ("--set", "preset=ci")):
            settings, page = self.run_html(*options, XDG_DATA_DIRS=str(self.folder))
            self.assertNotIn("CAPTURE", settings)
            self.assertIn("There is no picture, because three.js is not installed (on Debian: libjs-three).", page)

    @unittest.skipUnless(find_three(os.environ), "libjs-three is not installed")
    def test_capture(self):
        settings, page = self.run_html(VK_ASSAY_VALIDATION_LEVEL="content")
        self.assertTrue(settings["CAPTURE"].endswith("/scene-%p"))
        self.assertEqual(settings["CAPTURE_LIMIT_MIB"], "1024")
        self.assertIn("the capture of this run has no build", page)
        settings, _ = self.run_html("--capture", "kept")
        self.assertEqual(settings["CAPTURE"], str(self.folder / "kept"))
        self.assertNotIn("CAPTURE_LIMIT_MIB", settings)

    @unittest.skipUnless(find_three(os.environ), "libjs-three is not installed")
    def test_processes(self):
        """Each process has its capture; those of other runs do not count."""
        capture = self.capture()
        capture.build(1, capture.triangles(CORNERS, QUAD))
        capture.write()
        self.expect(self.run_script(f"""
            import shutil
            for i in range(2):
                if i == 1 and os.fork(): break
                load()
                folder = os.environ["VK_ASSAY_VALIDATION_CAPTURE"].replace("%p", str(os.getpid()))
                shutil.copytree({str(capture.folder)!r}, folder)
                with open(folder + "/builds.jsonl", "r+") as file:
                    text = file.read().replace('"pid": 7', f'"pid": {{os.getpid()}}', 1)
                    file.seek(0)
                    file.write(text)
                end()
            """, "--html", "a.html", "--level", "content"), 0)
        page, data = self.read("a.html"), self.page_data()
        self.assertEqual([len(view["moments"]) for view in data["scene"]["views"]], [1, 1])
        self.assertEqual(sorted(view["process"] for view in data["scene"]["views"]), [0, 1])
        self.assertIn("The MIT License. Copyright (c) 2010-2019 three.js authors", page)
        self.assertLess(len(page), 1_200_000)

    @unittest.skipUnless(find_three(os.environ), "libjs-three is not installed")
    def test_layer(self):
        """What the layer finds in boxes leads to the first whose first corner is not the least."""
        self.run_words("--level", "content", "--html", "a.html", "--", PROGRAMS, "null", "snapshots/aliases",
                       VK_LAYER_PATH=str(LAYERS))
        data = self.page_data()
        [found] = [one for one in data["new"] if one["id"] == "VUID-VkAabbPositionsKHR-minX-03546"]
        self.assertGreater(len(found["shown"]), 5)
        for view, write, geometry, primitive in found["shown"]:
            view = data["scene"]["views"][view]
            [mesh] = [one for one in view["meshes"] if one["write"] == write]
            box = mesh["geometries"][geometry]
            corners = list(struct.iter_unpack("<3f", base64.b64decode(view["arrays"][box["positions"]])))
            bad = [i for i in range(box["shown"]) if corners[8 * i][0] > corners[8 * i + 7][0]]
            self.assertEqual(bad[0], primitive)

    def test_damaged(self):
        """The page says why assay-scene fails."""
        capture = self.capture()
        capture.add("Build", n="?")
        if find_three(os.environ):
            self.write(capture)
            self.assertIn("There is no picture, because assay-scene fails: ", self.read("a.html"))
        self.write(capture, program=None, why="There is no picture, because assay-scene is not installed beside assay-run.")
        self.assertIn("assay-scene is not installed beside assay-run.", self.read("a.html"))


if __name__ == "__main__":
    main()
