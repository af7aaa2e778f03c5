# SPDX-License-Identifier: Apache-2.0
"""Reports: JUnit and SARIF as their schemas say, annotations, JSON, and lines of the source.

junit.xsd and sarif.py beside this file have what the specifications demand of the members that
assay-run writes. The official schemas are used in addition if ASSAY_TEST_SCHEMAS names a folder
with junit-10.xsd (Jenkins) and sarif-schema-2.1.0.json (OASIS)."""

import itertools
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

from runs import NASTY, TIME, VUID, Runs, finding, header, jsonschema, main, needs_jsonschema
from sarif import SARIF

HERE = pathlib.Path(__file__).resolve().parent
OFFICIAL = pathlib.Path(os.environ.get("ASSAY_TEST_SCHEMAS", "/nowhere"))
OBJECT = {"type": "VkBuffer", "handle": "0x1", "name": NASTY}
PLACE = {"module": "/app", "offset": "0x10"}
SUMMARY = {"Type": "Summary", "pid": 7, "Findings": {}, "HeldBack": {VUID: 3},
           "Unchecked": ["no memory"]}
RECORDS = {
    "clean": [header()],
    "not loaded": [],
    "one": [header(), finding()],
    "nasty": [header(), finding(MainMessage=NASTY, Objects=[OBJECT], SpecText=NASTY,
                                DebugRegion=NASTY), SUMMARY],
    "advice": [header(), finding("ASSAY-advice-leaked", Severity="Warning"),
               finding("ASSAY-advice-never-built", Severity="Warning", MainMessage=NASTY)],
    "several": [header(), finding(), finding(), finding("VUID-new", SpecUrl="https://a.invalid/#b"),
                finding("ASSAY-warning", Severity="Warning"), finding(call_site=[PLACE])],
}


class Reports(Runs):
    written = []

    def each(self):
        """Yields each record's name and result, with all its reports in self.folder, without and with a
        baseline. They are written once for all tests."""
        if not self.written:
            folder = tempfile.TemporaryDirectory(prefix="assay-test-")
            self.addClassCleanup(folder.cleanup)
            for name, known in itertools.product(RECORDS, (f"{VUID}\n", "VUID-old\n")):
                self.folder = pathlib.Path(folder.name) / str(len(self.written))
                self.write_record(*RECORDS[name])
                (self.folder / "known.txt").write_text(known)
                self.written.append((name, self.folder, self.run_words(
                    "--merge", "7.jsonl", "--baseline", "known.txt", "--strict-baseline",
                    "--junit", "a.xml", "--sarif", "a.sarif", "--json", "a.json", "--html", "a.html",
                    "--github")))
        for name, self.folder, result in self.written:
            yield name, result

    @unittest.skipUnless(shutil.which("xmllint"), "xmllint is not installed (libxml2-utils)")
    def test_junit_schemas(self):
        for _ in self.each():
            for schema in (HERE / "junit.xsd", OFFICIAL / "junit-10.xsd"):
                if schema.exists():
                    run = subprocess.run(["xmllint", "--noout", "--schema", schema, "a.xml"],
                                         cwd=self.folder, capture_output=True, check=False)
                    self.assertEqual(run.returncode, 0, run.stderr)

    @needs_jsonschema
    def test_sarif_schemas(self):
        for _ in self.each():
            jsonschema.validate(self.load("a.sarif"), SARIF)
            if (OFFICIAL / "sarif-schema-2.1.0.json").exists():
                jsonschema.validate(self.load("a.sarif"), self.load(OFFICIAL / "sarif-schema-2.1.0.json"))

    def test_junit_counts(self):
        for name, result in self.each():
            suite = ElementTree.parse(self.folder / "a.xml").getroot()[0]
            cases = list(suite)
            kinds = [child.tag for case in cases for child in case]
            self.assertEqual(int(suite.get("tests")), len(cases))
            for attribute, kind in (("failures", "failure"), ("errors", "error"),
                                    ("skipped", "skipped")):
                self.assertEqual(int(suite.get(attribute)), kinds.count(kind))
            self.assertEqual(result.status != 0, bool({"failure", "error"} & set(kinds)), name)

    def test_sarif_refers_to_its_rules(self):
        for _ in self.each():
            run = self.load("a.sarif")["runs"][0]
            rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
            self.assertEqual(len(rules), len(set(rules)))
            for result in run["results"]:
                self.assertIn(result["ruleId"], rules)

    def test_advice_is_no_failure(self):
        self.write_record(*RECORDS["advice"])
        result = self.expect(self.run_words("--merge", "7.jsonl", "--junit", "a.xml", "--json", "a.json"), 0,
                             "0 findings", "2 pieces of advice", "advice: infoCount is 0.")
        self.assertNotIn("assay-run: warning", result.err)
        cases = ElementTree.parse(self.folder / "a.xml").getroot()[0]
        self.assertEqual([(case.get("name"), [child.tag for child in case]) for case in cases],
                         [("the run", []), ("ASSAY-advice-leaked", ["skipped"]),
                          ("ASSAY-advice-never-built", ["skipped"])])
        self.assertEqual(len(self.load("a.json")["advice"]), 2)
        self.assertEqual(self.load("a.json")["warnings"], [])

    def test_advice_that_the_list_leaves_out(self):
        """The line of the advice says how much it is."""
        self.write_record(*RECORDS["advice"], {"Type": "Summary", "pid": 7, "time": TIME, "Findings": {},
                                               "HeldBack": {"ASSAY-advice-leaked": 3}, "Unchecked": []})
        self.assertNotIn("duplicate", self.run_words("--merge", "7.jsonl").err)
        self.expect(self.run_words("--merge", "7.jsonl", "--advice-is-error"), 99, "3 duplicates not reported")

    def test_advice_is_a_failure_if_asked_for(self):
        self.write_record(*RECORDS["advice"])
        self.expect(self.run_words("--merge", "7.jsonl", "--advice-is-error", "--junit", "a.xml"), 99,
                    "2 findings", "Warning: ASSAY-advice-leaked")
        suite = ElementTree.parse(self.folder / "a.xml").getroot()[0]
        self.assertEqual(suite.get("failures"), "2")
        self.write_record(header(), finding("ASSAY-warning", Severity="Warning"))
        self.expect(self.run_words("--merge", "7.jsonl", "--advice-is-error"), 0)

    def test_known_findings(self):
        self.write_record(*RECORDS["several"])
        (self.folder / "known.txt").write_text(VUID)
        self.run_words("--merge", "7.jsonl", "--baseline", "known.txt", "--sarif", "a.sarif",
                       "--json", "a.json")
        results = self.load("a.sarif")["runs"][0]["results"]
        self.assertEqual([result["ruleId"] for result in results if "suppressions" not in result],
                         ["VUID-new"])
        self.assertEqual(len(self.load("a.json")["known"]), 3)

    def test_fingerprints_do_not_depend_on_the_run(self):
        prints = []
        for handle in ("0x1", "0x2"):
            self.write_record(header(), finding(Objects=[{**OBJECT, "handle": handle}]))
            self.run_words("--merge", "7.jsonl", "--sarif", "a.sarif")
            prints.append(self.load("a.sarif")["runs"][0]["results"][0]["partialFingerprints"])
        self.assertEqual(*prints)

    def test_annotations(self):
        for name, result in self.each():
            lines = result.out.split("\n")[:-1]
            self.assertTrue(all(line.startswith("::error ") for line in lines), name)
            self.assertEqual(bool(lines), name in ("not loaded", "several") or
                             (name in ("one", "nasty") and "VUID-old" in
                              (self.folder / "known.txt").read_text()), name)

    def test_run_that_failed(self):
        self.run_script("load(); end(); sys.exit(3)", "--junit", "a.xml", "--sarif", "a.sarif")
        suite = ElementTree.parse(self.folder / "a.xml").getroot()[0]
        self.assertEqual(suite.get("errors"), "1")
        invocation = self.load("a.sarif")["runs"][0]["invocations"][0]
        self.assertFalse(invocation["executionSuccessful"])

    def test_command(self):
        """A finding says which command it is about: the ids of structures do not."""
        buffer = {"type": "VkCommandBuffer", "handle": "0x5", "name": "frame"}
        for members, line in (
                ({"Function": "vkCmdFoo"}, "in vkCmdFoo()"),
                ({"Function": "vkCmdFoo", "Objects": [buffer], "build": 3, "submission": 0,
                  "DebugRegion": "a::b"},
                 'in vkCmdFoo(), VkCommandBuffer 0x5 "frame", build 3, submission 0, labels a::b'),
                ({"Function": "vkFoo", "MainMessage": "vkFoo(): wrong.", "build": 1}, "in build 1")):
            self.write_record(header(), finding(**members))
            result = self.run_words("--merge", "7.jsonl", "--junit", "a.xml", "--github")
            self.assertIn(f"assay-run:   {line}\n", result.err)
            self.assertIn(f"{line}\n", result.out.replace("%0A", "\n"))
            self.assertIn(line, self.read("a.xml").replace("&quot;", '"'))
        self.write_record(header(), finding(build=3))
        self.assertNotIn("  in ", self.run_words("--merge", "7.jsonl").err)

    def test_json(self):
        self.run_script("load(); find(); end()", "--json", "a.json")
        report = self.load("a.json")
        self.assertEqual((report["loaded"], report["status"], len(report["new"])), (True, 99, 1))


def frame_finding(frame, **members):
    """A mistake in the code of a frame: handles, addresses, submissions and ages are the frame's."""
    return finding(**{
        "MainMessage": f"pInfos[0].scratchData 0x7f00{frame:04x}10 of VkCommandBuffer "
                       f"0x5500{frame:04x}[\"frame {frame % 3}\"], submission {frame}, age {frame}, is "
                       "no multiple of 256.",
        "Function": "vkCmdBuildAccelerationStructuresKHR",
        "Location": "pInfos[0].scratchData", "submission": frame, "queue": "0xabc123",
        "DebugRegion": f"frame {frame}",
        "Objects": [{"type": "VkCommandBuffer", "handle": f"0x5500{frame:04x}",
                     "name": f"frame {frame % 3}"},
                    {"type": "VkBuffer", "handle": f"0x6600{frame:04x}", "name": "scratch"}],
        **members})


class Repetition(Runs):
    """A mistake that is reported in each frame is one finding."""

    REPORTS = ("--junit", "a.xml", "--sarif", "a.sarif", "--json", "a.json", "--github")

    def merge(self, *findings):
        self.write_record(header(), *findings)
        return self.run_words("--merge", "7.jsonl", *self.REPORTS)

    def test_instance_is_not_destroyed(self):
        """Nothing says how many duplicates were held back."""
        limited = header(Settings={"duplicate_message_limit": "10"})
        unknown = "1 finding (reported 10 times, perhaps found more often: a VkInstance was not destroyed)"
        for lines, text in (([limited] + 10 * [finding()], unknown),
                            ([limited] + 9 * [finding()], "1 finding (reported 9 times) in"),
                            ([header()] + 10 * [finding()], "1 finding (reported 10 times) in"),
                            ([limited] + 10 * [finding()] + [{**SUMMARY, "HeldBack": {}}],
                             "1 finding (reported 10 times) in")):
            self.write_record(*lines)
            self.expect(self.run_words("--merge", "7.jsonl"), 99, text)

    def test_one_mistake_in_20_frames(self):
        result = self.merge(*map(frame_finding, range(20)))
        self.expect(result, 99, "1 finding (reported 20 times)",
                    "20 times, from submission 0 to submission 19, in 3 command buffers: frame 0, "
                    "frame 1, frame 2")
        self.assertEqual(result.out.count("::error"), 1)
        self.assertIn("20 times", result.out)
        results = self.load("a.sarif")["runs"][0]["results"]
        self.assertEqual([one["occurrenceCount"] for one in results], [20])
        self.assertEqual(self.read("a.xml").count("is no multiple"), 2)  # attribute and text
        report = self.load("a.json")
        self.assertEqual(len(report["new"]), 20)
        self.assertEqual(report["mistakes"], [{
            "VUID": VUID, "count": 20, "first_submission": 0, "last_submission": 19,
            "command_buffers": ["frame 0", "frame 1", "frame 2"], "objects": ["scratch"]}])

    def test_first_and_last_frame(self):
        self.expect(self.merge(*(finding(submission=n, frame=frame) for n, frame in ((1, 12), (900, 1340), (7, 20)))),
                    99, "3 times, from submission 1 to submission 900, first seen in frame 12, last in 1,340")
        properties = self.load("a.sarif")["runs"][0]["results"][0]["properties"]
        self.assertEqual((properties["first_frame"], properties["last_frame"]), (12, 1340))
        self.assertIn("first seen in frame 12, last in 1,340", self.read("a.xml"))

    def test_many_command_buffers(self):
        unnamed = [frame_finding(frame, Objects=[{"type": "VkCommandBuffer",
                                                  "handle": f"0x5500{frame:04x}"}], DebugRegion="")
                   for frame in range(5)]
        self.expect(self.merge(*unnamed), 99,
                    "in 5 command buffers: 0x55000000, 0x55000001, 0x55000002 and 2 more")

    def test_one_mistake_about_20_objects(self):
        """Streamed objects go through one line of code: of the same call site, or command and member."""
        site = [{"module": "/app", "offset": "0x10"}]
        for members in ({"call_site": site}, {}):
            with self.subTest(members):
                result = self.merge(*(frame_finding(
                    i, Objects=[{"type": "VkAccelerationStructureKHR", "handle": "0x77000", "name": f"chunk{i}"}],
                    Location=f"pInfos[{i}].scratchData", DebugRegion=f"frame {i}",
                    MainMessage=f"pInfos[{i}].scratchData of build {i} writes bytes {i} to {i + 41271}.",
                    **members) for i in range(20)))
                self.expect(result, 99, "1 finding (reported 20 times)",
                            "20 objects: chunk0, chunk1, chunk2 and 17 more")
                self.assertNotIn("also:", result.err)
                self.assertEqual(result.out.count("::error"), 1)
                self.assertIn("20 objects: chunk0", result.out)
                results = self.load("a.sarif")["runs"][0]["results"]
                self.assertEqual([one["occurrenceCount"] for one in results], [20])
                self.assertIn("20 objects: chunk0", results[0]["message"]["text"])
                self.assertIn("20 objects: chunk0", self.read("a.xml"))
                [mistake] = self.load("a.json")["mistakes"]
                self.assertEqual(mistake["objects"], [f"chunk{i}" for i in range(20)])

    def test_other_messages_of_a_mistake(self):
        """One line of code may break a rule in two ways: the finding names both."""
        site = [{"module": "/app", "offset": "0x10"}]
        messages = [f"pInfos[{i}].{member} is wrong." for i in range(2)
                    for member in ("scratchData", "dst", "src", "flags")]
        self.expect(self.merge(*(frame_finding(0, MainMessage=text, Location=text.split()[0], call_site=site)
                                 for text in messages)),
                    99, "1 finding (reported 8 times)", "also: pInfos[0].dst is wrong.",
                    "also: pInfos[0].src is wrong.", "and 1 other message of this id")

    def test_what_makes_two_mistakes(self):
        frame = {"module": "/app", "offset": "0x10"}
        for members in ({"VUID": "VUID-other"}, {"Location": "pInfos[0].dstAccelerationStructure"},
                        {"call_site": [frame]}, {"Severity": "Warning"}, {"Function": "vkCmdCopyBuffer"},
                        {"DebugRegion": "terrain"}):
            with self.subTest(members):
                result = self.merge(frame_finding(0), {**frame_finding(1), **members})
                self.assertNotIn("2 times", result.err)
                self.assertNotIn("reported 2 times", result.err)

    def test_two_lines_of_code(self):
        self.expect(self.merge(*(frame_finding(i, call_site=[{"module": "/app", "offset": f"0x{i % 2}"}])
                                 for i in range(4))),
                    99, "2 findings (reported 4 times)")

    def test_labels_count_without_call_sites(self):
        self.expect(self.merge(*(frame_finding(0, DebugRegion=label)
                                 for label in ("frame 1::terrain", "frame 1::figure", "frame 2::terrain"))),
                    99, "2 findings (reported 3 times)")

    def test_objects_of_advice_count(self):
        advice = [finding("ASSAY-advice-worst", Severity="Warning", Objects=[
            {"type": "VkAccelerationStructureKHR", "handle": "0x1", "name": name}]) for name in "aba"]
        self.write_record(header(), *advice)
        self.expect(self.run_words("--merge", "7.jsonl", "--advice-is-error"), 99, "2 findings (reported 3 times)")


@unittest.skipUnless(shutil.which("cc") and shutil.which("addr2line"), "needs cc and addr2line")
class CallSites(Runs):
    """A program prints the address of a call; the record has it as the layer would."""

    SOURCE = """#include <stdio.h>
extern char __executable_start;
__attribute__((noinline)) static void *record_build(void)
{
    return (char *)__builtin_return_address(0) - (unsigned long)&__executable_start;
}
int main(void)
{
    void *address = record_build(); /* line 9 */
    printf("%p\\n", address);
    return 0;
}
"""

    def make_program(self, name):
        folder = self.folder / name
        folder.mkdir()
        (folder / "app.c").write_text(self.SOURCE, encoding="utf-8")
        subprocess.run(["cc", "-g", "-O1", "-o", folder / "app", folder / "app.c"], check=True)
        offset = subprocess.run([folder / "app"], capture_output=True, encoding="utf-8",
                                check=True).stdout.strip()
        return {"module": str(folder / "app"), "offset": offset}

    def run_with(self, *frames):
        self.write_record(header(), finding(call_site=list(frames)))
        result = self.run_words("--merge", "7.jsonl", "--sarif", "a.sarif", "--github")
        sarif = self.load("a.sarif")
        place = sarif["runs"][0]["results"][0]["locations"][0]["physicalLocation"]
        return result, place

    def test_line(self):
        # Characters that a URI, addr2line's output or an annotation give a meaning.
        for name in ("source", "with space", "a (discriminator 3)", "a:b,c%20#", "é"):
            with self.subTest(name):
                result, place = self.run_with(
                    {"module": "/gone", "offset": "0x1"}, self.make_program(name))
                self.assertIn(f"{name}/app.c:9 in main", result.err)
                self.assertEqual(place["region"]["startLine"], 9)
                self.assertIn("line=9", result.out)
                self.assertRegex(place["artifactLocation"]["uri"], r"^[!-~]+/app\.c$")
                self.assertEqual(place["artifactLocation"]["uriBaseId"], "%SRCROOT%")

    def test_source_elsewhere(self):
        frame = self.make_program("source")
        (self.folder / "elsewhere").mkdir()
        self.write_record(header(), finding(call_site=[frame]), name="elsewhere/7.jsonl")
        subprocess.run([sys.executable, "-B", str(HERE.parent.parent / "scripts/assay-run"),
                        "--merge", "7.jsonl", "--sarif", "a.sarif"],
                       cwd=self.folder / "elsewhere", stderr=subprocess.DEVNULL, check=False)
        self.assertIn('"uri": "file:///', self.read("elsewhere/a.sarif"))

    def test_unknown_module(self):
        result, place = self.run_with({"module": "/gone", "offset": "0x1"},
                                      {"module": "unknown module", "offset": "0x2"})
        self.assertEqual(place["region"]["startLine"], 1)
        self.assertIn("  at /gone+0x1\n", result.err)
        self.assertIn("  from unknown module+0x2\n", result.err)

    def test_start_of_the_program(self):
        """If only the C library has debug information, its lines are not reported."""
        frame = self.make_program("source")
        library = self.folder / "libc.so.6"
        pathlib.Path(frame["module"]).rename(library)
        result, place = self.run_with({"module": "/gone", "offset": "0x1"},
                                      {**frame, "module": str(library)})
        self.assertEqual(place["region"]["startLine"], 1)
        self.assertNotIn("app.c", result.err)


if __name__ == "__main__":
    main()
