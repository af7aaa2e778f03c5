# SPDX-License-Identifier: Apache-2.0
"""The page of --html in headless Chromium."""

import unittest
import unittest.mock

from browser import CHROMIUM, OfPages
from runs import NASTY, TIME, VUID, Runs, finding, header, main
from assay_run.page import Clock, build_data

QUEUE = "0x7f0000000010"


def build(number, **members):
    return {"Type": "Build", "pid": 7, "time": TIME, "device": "0x7f0000000001", "queue": QUEUE,
            "submission": number // 10, "command_buffer": f"0x7f00{number // 10:08x}",
            "build": number % 10, "mode": "update" if number % 3 else "build",
            "type": "bottom level", "dst": f"0x7f{number // 3:010x}",
            "dst_name": f"mesh {number // 3}", "src": f"0x7f{number // 3:010x}", "geometries": 1,
            "primitives": 1000 + number, "size": 65536 + number // 3,
            "memory": f"0x7f{number // 300:010x}", "memory_offset": number // 3 * 65536, **members}


def compacted_size(number, **members):
    return {"Type": "CompactedSize", "pid": 7, "time": TIME, "device": "0x7f0000000001",
            "dst": f"0x7f{number:010x}", "compacted_size": 32768 + number, **members}


def findings():
    return [
        finding(MainMessage=NASTY, Objects=[{"type": "VkBuffer", "handle": "0xabc",
                                             "name": "vertices of the duck"}],
                DebugRegion="frame::shadows", SpecText="infoCount must be greater than 0",
                SpecUrl="https://docs.vulkan.org/spec", queue=QUEUE, submission=5),
        finding("VUID-second", MainMessage="scratchData is misaligned.", queue=QUEUE, submission=6,
                SpecUrl="javascript:alert(1)",
                call_site=[{"module": "/app", "offset": "0x10"}], also=["VUID-third"]),
        finding("VUID-second", MainMessage="scratchData is misaligned, too."),
        finding("VUID-known", MainMessage="A known finding."),
    ]


class Rows(unittest.TestCase):
    def test_too_many(self):
        lines = [(0, build(i)) for i in range(5)] + [(0, header())]
        with unittest.mock.patch("assay_run.page.MOST_ROWS", 3):
            made = build_data(lines, Clock(lines))
        self.assertEqual((len(made["rows"]), made["leftOut"]), (3, 2))


@unittest.skipUnless(CHROMIUM, "Chromium is not installed")
class Page(OfPages, Runs):
    def open(self, *lines, width=1200):
        self.write_record(*lines)
        (self.folder / "known.txt").write_text("VUID-known\n")
        self.run_words("--merge", "7.jsonl", "--baseline", "known.txt", "--html", "a.html")
        self.browser.open(self.folder / "a.html", width)

    def open_example(self, **options):
        self.open(header(), *findings(), *map(build, range(600)), compacted_size(42), **options)

    def count(self, selector):
        return self.browser.run(f"document.querySelectorAll({selector!r}).length")

    def text(self, selector):
        return self.browser.run(f"document.querySelector({selector!r}).innerText")

    def test_findings(self):
        self.open_example()
        self.assertEqual(self.text("#verdict"), "3 findings.")
        self.assertEqual(self.count("#groups .group"), 2)
        self.assertEqual(self.count("#groups .finding"), 3)
        text = self.text("#groups")
        for part in (VUID, "vertices of the duck", "infoCount must be greater than 0", "frame",
                     "/app+0x10", "</script>", "submission 5", "also violates VUID-third"):
            self.assertIn(part, text)
        self.assertEqual(self.count("#groups a"), 1)  # and none to a script

    def test_filters(self):
        self.open_example()
        self.browser.run("document.querySelector('#text').focus()")
        self.browser.type("DUCK vert")
        self.assertEqual(self.count(".finding"), 1)
        self.assertEqual(self.text("#count"), "1 finding")
        self.browser.run("text.value = ''; id.value = 'VUID-second'; "
                         "id.dispatchEvent(new Event('input', {bubbles: true}))")
        self.assertEqual(self.count(".finding"), 2)
        self.browser.run("id.value = 'VUID-third'; "
                         "id.dispatchEvent(new Event('input', {bubbles: true}))")
        self.assertEqual(self.count(".finding"), 1)
        self.browser.run("id.value = ''; known.click()")
        self.assertEqual(self.count(".finding"), 4)

    def choose(self, control, value):
        self.browser.run(f"{control}.value = {value!r}; "
                         f"{control}.dispatchEvent(new Event('input', {{bubbles: true}}))")

    def test_grouping(self):
        """A finding about two structures is in the groups of both."""
        objects = [{"type": "VkAccelerationStructureKHR", "handle": f"0x{i}"} for i in (1, 2)]
        self.open(header(), finding(Objects=objects, queue=QUEUE, submission=5), finding("VUID-second"))
        self.choose("group", "structure")
        self.assertEqual(self.count("#groups .group"), 3)
        self.assertIn("0x1 (1)", self.text("#groups"))
        self.assertIn(VUID, self.text("#groups .finding"))
        self.choose("group", "submission")
        self.assertEqual(self.count("#groups .group"), 2)
        self.assertIn(f"submission 5 to queue {QUEUE} (1)", self.text("#groups"))

    def test_fold(self):
        self.open_example()
        self.browser.run("fold.click()")
        self.assertEqual(self.count("details.group[open]"), 0)
        self.browser.run("fold.click()")
        self.assertEqual(self.count("details.group[open]"), 2)

    def test_sections(self):
        self.open_example()
        self.assertEqual(self.text("#sections").split("\n"),
                         ["Findings", "Submissions", "Memory", "Acceleration structures"])

    def test_advice(self):
        """In the order of the log, which is the list's, and not among the notes."""
        advice = [finding(f"ASSAY-advice-{name}", Severity="Warning", MainMessage=f"The {name} one.", Objects=[
            {"type": "VkAccelerationStructureKHR", "handle": "0x7f0000000000", "name": "mesh 0"}])
            for name in ("worst", "better", "worst")]
        self.open(header(), *advice, *map(build, range(6)))
        self.assertIn("No findings; 2 pieces of advice.", self.text("#verdict"))
        self.assertEqual(self.browser.run("document.querySelector('#verdict').className"), "good")
        self.assertEqual(self.text("#advice .group summary"), "ASSAY-advice-worst (1)")
        self.assertEqual(self.count("#advice .group"), 2)
        self.assertIn("2 times", self.text("#advice .group"))
        self.assertNotIn("better", self.browser.run("document.querySelector('#notes').textContent"))
        self.assertIn("2 pieces of advice", self.text("#structures tr"))
        self.choose("order", "findings")
        self.browser.run("document.querySelector('#structures .link').click()")
        self.assertEqual(self.browser.run("text.value"), "0x7f0000000000")
        self.assertEqual(self.count("#advice .finding"), 2)
        self.open(header(), build(0))
        self.assertTrue(self.browser.run("document.querySelector('#advice-section').hidden"))

    def test_advice_about_structures_without_names(self):
        self.open(header(), *(finding("ASSAY-advice-leaked", Severity="Warning", MainMessage="It leaks.", Objects=[
            {"type": "VkAccelerationStructureKHR", "handle": handle}]) for handle in ("0x1", "0x2", "0x2")))
        self.assertEqual(self.count("#advice .finding"), 2)

    def test_links(self):
        """From a finding to its structure and to its submission."""
        structure = [{"type": "VkAccelerationStructureKHR", "handle": "0x7f0000000003", "name": "mesh 3"}]
        self.open(header(), *map(build, range(60)), finding(Objects=structure, queue=QUEUE, submission=2))
        self.assertEqual(self.count("#groups .link"), 2)
        self.browser.run("document.querySelectorAll('#groups .link')[0].click()")
        self.assertEqual(self.count("#structures tr"), 1)
        self.assertIn("1 finding", self.text("#structures tr"))
        self.browser.run("document.querySelectorAll('#groups .link')[1].click()")
        self.assertIn("Submission 2: 10 builds and copies, 1 finding", self.text("#selected"))
        self.open(header(), finding(Objects=structure, queue=QUEUE, submission=2))
        self.assertEqual(self.count("#groups .link"), 1)  # no structure is known

    def test_time(self):
        later = "2026-11-22T18:00:01.250001Z"
        self.open(header(), build(0), build(10, time=later),
                  finding(queue=QUEUE, submission=1, time=later))
        self.assertIn("1.250 s after the start", self.text("#groups .finding"))
        self.browser.run("document.querySelectorAll('#timeline button')[1].focus()")
        self.assertIn("1.250 s after the start", self.text("#selected"))
        self.open(header(time="?"), build(0, time="?"))
        self.browser.run("document.querySelector('#timeline button').focus()")
        self.assertNotIn("after the start", self.text("#selected"))

    def test_frames(self):
        """On the axes, of a column, and of a finding; nothing before the first frame."""
        numbers = [{**self.submission(number), **({"frame": 10 * number} if number else {})} for number in range(3)]
        self.open(header(), numbers[0], build(0, size=1), *numbers[1:],
                  finding(queue=QUEUE, submission=2, frame=20), finding(frame=30))
        for axis in ("#timeline .axis", "#memory .axis"):
            text = self.text(axis).split("\n")
            self.assertNotIn("frame", text[0])
            self.assertIn(", frame 20 (0.000 s)", text[1])
        self.browser.run("document.querySelectorAll('#timeline button')[2].focus()")
        self.assertIn("Submission 2, frame 20: 0 builds and copies, 1 finding", self.text("#selected"))
        self.assertIn(", frame 20, 0.000 s after the start", self.text("#groups .finding"))
        self.assertIn("first seen in frame 20, last in 30", self.text("#groups .finding"))

    def destroyed(self, number, **members):
        return {"Type": "Destroyed", "pid": 7, "time": TIME, "device": "0x7f0000000001",
                "dst": f"0x7f{number:010x}", **members}

    def submission(self, number):
        return {"Type": "Submission", "pid": 7, "time": TIME, "device": "0x7f0000000001", "queue": QUEUE,
                "submission": number, "command_buffers": []}

    def test_memory(self):
        """The peak is where all are alive; a structure that is built again counts once."""
        self.open(header(), self.submission(1), build(0, size=1 << 20), self.submission(2),
                  build(3, size=3 << 20), build(3, size=3 << 20), self.destroyed(0), self.submission(3),
                  build(6, size=1 << 19))
        self.assertIn("Peak: submission 2, 0.000 s: 4 MiB. At the end: 3.5 MiB.", self.text("figcaption"))
        self.assertEqual(self.count("#memory svg path"), 2)
        self.assertEqual(self.text("#memory .axis").split("\n"), ["submission 1 (0.000 s)", "submission 3 (0.000 s)"])
        self.assertIn("2 alive at the end", self.text("#totals"))
        self.choose("structure", "destroyed after submission 2")
        self.assertEqual(self.count("#structures tr"), 1)
        self.choose("structure", "")
        self.choose("order", "size")
        self.assertIn("mesh 1", self.text("#structures tr"))

    def test_handle_used_again_after_destruction(self):
        self.open(header(), build(0), self.destroyed(0), build(0), self.destroyed(1))
        self.assertIn("2 structures", self.text("#totals"))
        self.assertIn("1 alive at the end", self.text("#totals"))

    def test_written_by_no_build(self):
        copy = {**build(3), "Type": "Copy", "mode": "clone"}
        self.open(header(), build(1), copy)
        for row, part in ((1, "update, command buffer 0x7f0000000000, build 1, submission 0"), (2, "clone of")):
            text = self.text(f"#structures tr:nth-child({row})")
            self.assertIn(part, text)
            self.assertEqual(text.split("\t")[2].strip(), "0")  # builds

    def test_flags(self):
        self.open(header(), build(0, flags="0x1005"), build(3, flags="0x0"))
        self.assertIn("ALLOW_UPDATE, PREFER_FAST_TRACE, 0x1000", self.text("#structures tr"))
        self.assertIn("no flags", self.text("#structures tr:nth-child(2)"))

    def test_scratch(self):
        self.open(header(), build(0, scratch_size=256), build(1, scratch_size=64), build(3, scratch_size=512))
        self.assertEqual(self.text("#structures td[data-title=scratch]").split("\n"), ["256", "update:\u00a064"])
        self.choose("order", "scratch")
        self.assertEqual(self.text("#structures td[data-title=scratch]"), "512")

    def test_instances(self):
        """What they refer to, and how many refer to nothing; none of a structure that is gone."""
        line = {"Type": "Instances", "pid": 7, "time": TIME, "device": "0x7f0000000001", "queue": QUEUE,
                "submission": 0, "build": 0, "dst": "0x7f0000000000", "structure_count": 2,
                "structures": [{"handle": "0x1", "name": "rock", "instances": 1000},
                               {"handle": "0x2", "instances": 1}]}
        self.open(header(), build(0, primitives=1003), line)
        self.assertIn("instances: 1,000 × “rock”, 1 × 0x2, 2 × no live structure", self.text("#structures tr"))
        self.open(header(), build(0, primitives=1001), line)
        self.assertNotIn("no live", self.text("#structures tr"))
        many = [{"handle": f"0x{i}", "instances": 1} for i in range(20)]
        self.open(header(), build(0), {**line, "structures": many, "structure_count": 21})
        self.assertIn("1 × 0x7, 13 structures more", self.text("#structures tr"))
        self.assertNotIn("no live", self.text("#structures tr"))
        self.open(header(), build(0), self.destroyed(0), line)
        self.assertEqual(self.count("#structures tr"), 1)
        self.assertNotIn("instances:", self.text("#structures tr"))

    def test_columns_are_wider_than_their_words(self):
        for width in (1400, 800):
            self.open_example(width=width)
            cut = self.browser.run("""[...document.querySelectorAll('th')].filter(
                cell => cell.scrollWidth > cell.clientWidth || cell.clientHeight > 40).length""")
            self.assertEqual(cut, 0)
            self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), width)

    def test_time_line(self):
        self.open_example()
        self.assertEqual(self.count("#timeline .queue"), 1)
        self.assertEqual(self.count("#timeline button"), 60)
        self.assertEqual(self.count("#timeline button.bad"), 2)

    def test_structures(self):
        self.open_example()
        self.assertEqual(self.count("#structures tr"), 100)
        self.assertIn("200 structures", self.text("#totals"))
        self.browser.run("structure.focus()")
        self.browser.type("mesh 42")
        self.assertEqual(self.count("#structures tr"), 1)
        row = self.text("#structures tr")
        for part in ("mesh 42", "65,578", "32,810", "1,128", "compacted:", "0x7f0000000000", "+ 2,752,512", "alive",
                     "bottom level"):
            self.assertIn(part, row)

    def test_handle_used_again(self):
        """A structure in other memory is another one; a build of the same structure is not."""
        self.open(header(), build(0), build(0, submission=1), build(0, size=4), build(0, memory_offset=1))
        self.assertIn("3 structures, 131,076 bytes", self.text("#totals"))

    def test_finding_at_recording(self):
        """It belongs to the first submission of its command buffer afterwards."""
        buffer = {"Objects": [{"type": "VkCommandBuffer", "handle": "0x7f0000000000"}],
                  "device": "0x7f0000000001"}
        self.open(header(), build(0, submission=1), finding(**buffer), finding(pid=8, **buffer),
                  build(0, submission=2), build(0, submission=3))
        self.assertEqual(self.count("#timeline button.bad"), 1)
        self.browser.run("document.querySelector('#timeline button.bad').focus()")
        self.assertIn("Submission 2: 1 build or copy, 1 finding", self.text("#selected"))

    def test_host(self):
        host = {"queue": None, "submission": None, "command_buffer": None}
        lines = [{key: value for key, value in build(i, **host).items() if value is not None}
                 for i in range(3)]
        self.open(header(), *lines)
        self.assertEqual(self.text("#timeline h3"), "Host")
        self.assertEqual(self.count("#timeline button"), 3)

    def test_clean(self):
        self.open(header())
        self.assertEqual(self.text("#verdict"), "No findings.")
        self.assertEqual(self.count("section:not([hidden])"), 2)  # findings and notes
        self.assertIn("--set record_builds=true", self.text("#notes"))

    def test_not_loaded(self):
        self.open()
        self.assertIn("the layer was not loaded", self.text("#verdict"))

    def test_narrow(self):
        self.open_example(width=400)
        self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), 400)
        cut = self.browser.run("""[...document.querySelectorAll(
            'h1, h2, h3, p, li, summary, label, input, select, td')].filter(element => {
                const box = element.getBoundingClientRect();
                return box.width && (box.left < 0 || box.right > 400);
            }).map(element => element.outerHTML)""")
        self.assertEqual(cut, [])
        self.assertGreaterEqual(self.browser.run(
            "parseFloat(getComputedStyle(document.querySelector('.finding p')).fontSize)"), 14)

    def test_keyboard(self):
        """Tab reaches each control, the focus can be seen, and keys operate them."""
        self.open_example()
        reached = []
        for _ in range(200):
            self.browser.press("Tab", 9)
            reached.append(self.browser.run("""(() => {
                const element = document.activeElement;
                return element.id || element.className || element.tagName;
            })()"""))
            if reached[-1] == "BODY":
                break
            self.assertNotEqual(self.browser.run(
                "getComputedStyle(document.activeElement).outlineStyle"), "none", reached[-1])
        for control in ("skip", "text", "id", "known", "fold", "SUMMARY", "link", "bad chosen", "structure", "order",
                        "scroll", "more"):
            self.assertIn(control, reached)
        self.assertEqual(sorted(set(reached), key=reached.index)[:7],
                         ["skip", "SUMMARY", "A", "text", "id", "group", "known"])

    def test_keys_operate(self):
        self.open_example()
        self.browser.run("known.focus()")
        self.browser.press(" ", 32, " ")
        self.assertEqual(self.count(".finding"), 4)
        self.browser.run("document.querySelector('.group summary').focus()")
        self.browser.press("Enter", 13, "\r")
        self.assertEqual(self.count("details.group[open]"), 2)
        self.browser.run("more.focus()")
        self.browser.press("Enter", 13, "\r")
        self.assertEqual(self.count("#structures tr"), 200)
        self.browser.run("document.querySelector('#timeline button.bad').focus()")
        self.assertIn("1 finding", self.text("#selected"))
        self.assertEqual(self.count("#commands li"), 10)

    def test_printing(self):
        self.open_example()
        self.browser.run("document.querySelector('.group').open = false")
        self.assertTrue(self.browser.print_to_pdf().startswith(b"%PDF"))
        self.assertEqual(self.count("details.group[open]"), 2)  # what is folded would be missing

    def test_size(self):
        self.open(header(), *findings(), *map(build, range(10000)))
        self.assertLess((self.folder / "a.html").stat().st_size, 2_000_000)
        self.assertLessEqual(self.count("#timeline button"), 100)

    def test_several_processes(self):
        self.open(header(), header(pid=8), build(0), build(0, pid=8))
        self.assertEqual(self.count("#timeline .queue"), 2)
        self.assertIn("process 8", self.text("#timeline"))
        self.assertIn("2 structures", self.text("#totals"))

    def test_dark(self):
        self.open_example()
        self.browser.call("Emulation.setEmulatedMedia",
                          features=[{"name": "prefers-color-scheme", "value": "dark"}])
        self.assertEqual(self.browser.run("getComputedStyle(document.body).backgroundColor"),
                         "rgb(21, 25, 30)")


if __name__ == "__main__":
    main()
