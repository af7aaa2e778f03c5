# SPDX-License-Identifier: Apache-2.0
"""Call sites end to end: a finding leads to the line that recorded the build, in all reports."""

import pathlib
import re
import shutil
import sys
import unittest

from runs import Runs

PROGRAMS, LAYERS, DRIVER = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
HERE = pathlib.Path(__file__).resolve().parent
RECORDER, MAIN = HERE / "programs/record_build.c", HERE / "programs/call_sites.c"
MODES = ("frames", "full")
# What is found when: at the call, at the submission, and when that has completed.
CALLS = {"device": ("parameters", "execution", "content"), "secondary": ("execution", "content"),
         "indirect": ("parameters", "execution"), "nv": ("parameters", "execution"),
         "host": ("parameters", "execution", "content"), "deferred": ("execution",)}
COMMENTS = {"secondary": "device", "deferred": "host"}


def line_of(file, comment):
    lines = file.read_text(encoding="utf-8").splitlines()
    [number] = [i for i, line in enumerate(lines, 1) if line.endswith(f"/* {comment} */")]
    return number


class CallSites(Runs):
    def setUp(self):
        super().setUp()
        self.environment.update(VK_LAYER_PATH=str(LAYERS), VK_DRIVER_FILES=str(DRIVER),
                                VK_LOADER_LAYERS_DISABLE="~implicit~")

    def run_program(self, arguments, mode, program="assay_call_sites", options=()):
        """Returns the result of a run that has findings."""
        level = arguments.split()[1]
        return self.expect(self.run_words(
            "--level", level, "--set", f"call_sites={mode}", "--json", "a.json", *options, "--",
            PROGRAMS / program, *arguments.split()), 99)

    def found(self):
        return self.load("a.json")["new"]

    def assert_lines(self, command, module=None):
        """Each finding leads to record_build() and its caller."""
        for finding in self.found():
            first, second = finding["call_site"][:2]
            self.assertEqual(pathlib.Path(first["file"]).resolve(), RECORDER)
            self.assertEqual(first["line"], line_of(RECORDER, COMMENTS.get(command, command)))
            self.assertEqual(first["function"], "record_build")
            self.assertEqual(second["line"], line_of(MAIN, "caller"))
            self.assertEqual(second["function"], "call_inlined")
            self.assertEqual([(one["function"], one["line"]) for one in second["inlined_into"]],
                             [("make_call", line_of(MAIN, "inliner"))])
            if module:
                self.assertEqual(first["module"], str(PROGRAMS / module))

    def test_commands(self):
        for mode in MODES:
            for command, levels in CALLS.items():
                for level in levels:
                    with self.subTest(f"{mode}: {command} {level}"):
                        self.run_program(f"{command} {level}", mode)
                        self.assert_lines(command)

    def test_program_at_a_fixed_address(self):
        for mode in MODES:
            for level in CALLS["device"]:
                self.run_program(f"device {level}", mode, "assay_call_sites_fixed")
                self.assert_lines("device", "assay_call_sites_fixed")
                self.assertGreater(int(self.found()[0]["call_site"][0]["offset"], 16), 0x400000)

    def test_library_that_is_closed_before_the_submission(self):
        [library] = PROGRAMS.glob("libassay_call_sites_library.so")
        for mode in MODES:
            for level in CALLS["device"]:
                self.run_program(f"device {level} library={library}", mode)
                self.assert_lines("device", library.name)

    def test_program_without_frame_pointers_and_debug_information(self):
        for mode in MODES:
            result = self.run_program("device execution", mode, "assay_call_sites_plain",
                                      ("--sarif", "a.sarif", "--github"))
            for finding in self.found():
                first = finding["call_site"][0]
                self.assertEqual(first["module"], str(PROGRAMS / "assay_call_sites_plain"))
                self.assertNotIn("file", first)
            self.assertRegex(result.err, r"  at \S+/assay_call_sites_plain\+0x[0-9a-f]+")
            sarif = self.load("a.sarif")
            for one in sarif["runs"][0]["results"]:
                self.assertIn("assay_call_sites_plain",
                              one["locations"][0]["physicalLocation"]["artifactLocation"]["uri"])

    def test_baseline(self):
        """A new mistake of the same id in another function is not known."""
        known = self.folder / "known.txt"
        for condition, status in (("fn:make_call", 0), ("file:*/record_build.c", 0), ("fn:other", 99)):
            self.run_program("device execution", "full")
            ids = {finding["VUID"] for finding in self.found()}
            known.write_text("".join(f"{name}@{condition}\n" for name in ids))
            self.expect(self.run_words("--level", "execution", "--baseline", known, "--",
                                       PROGRAMS / "assay_call_sites", "device", "execution"), status)

    def test_reports(self):
        """The goal: annotations on the line that recorded the bad build."""
        for mode in MODES:
            for level in CALLS["device"]:
                with self.subTest(f"{mode}: {level}"):
                    self.check_reports(f"device {level}", mode)

    def check_reports(self, arguments, mode):
        result = self.run_program(arguments, mode, options=(
            "--sarif", "a.sarif", "--junit", "a.xml", "--html", "a.html", "--github"))
        line, caller = line_of(RECORDER, "device"), line_of(MAIN, "caller")
        sarif = self.load("a.sarif")
        for one in sarif["runs"][0]["results"]:
            [location] = one["locations"]
            self.assert_place(location, RECORDER, line)
            frames = [frame["location"] for frame in one["stacks"][0]["frames"]]
            self.assert_place(frames[0], RECORDER, line)
            self.assert_place(frames[1], MAIN, caller)
        self.assertRegex(result.err, rf"  at \S*record_build\.c:{line} in record_build\n")
        self.assertRegex(result.err, rf"  from \S*call_sites\.c:{caller} in call_inlined\n"
                                     r"\S*   from \S*call_sites\.c:\d+ in make_call\n")
        self.assertRegex(result.out, rf"file=[^,]*record_build\.c,line={line},")
        for name in ("a.xml", "a.html"):
            self.assertRegex(self.read(name), rf"record_build\.c:{line} in record_build")

    def assert_place(self, location, file, line):
        place = location["physicalLocation"]
        self.assertTrue(place["artifactLocation"]["uri"].endswith(f"/{file.name}"), place)
        self.assertEqual(place["region"]["startLine"], line)

    def test_off(self):
        self.run_program("device execution", "off")
        for finding in self.found():
            self.assertNotIn("call_site", finding)

    def test_text(self):
        result = self.run_words("--level", "execution", "--set", "call_sites=frames", "--json",
                                "a.json", "--", "sh", "-c",
                                f"VK_ASSAY_VALIDATION_LOG_FORMAT=text VK_ASSAY_VALIDATION_LOG_FILENAME="
                                f"log.txt {PROGRAMS}/assay_call_sites device execution")
        self.assertEqual(result.status, 98)
        text = self.read("log.txt")
        program = re.escape(str(PROGRAMS / "assay_call_sites"))
        self.assertRegex(text, rf"submission \d+\. Called from {program}\+0x[0-9a-f]+, {program}\+0x")


if __name__ == "__main__":
    if not shutil.which("addr2line"):
        print("addr2line is not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
