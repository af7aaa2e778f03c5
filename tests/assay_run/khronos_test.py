# SPDX-License-Identifier: Apache-2.0
"""--count-khronos, with applications that write the log of a Khronos layer, old or new."""

import os
import pathlib
import textwrap
import time
import unittest
import xml.etree.ElementTree as ElementTree

from runs import VUID, Runs, header, main
from assay_run.khronos import KhronosLog
from assay_run.khronos_messages import last_heading, read_messages

OTHER = "VUID-vkCmdDraw-None-08606"
SCRATCH = "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03710"
# As layer 1.3.239 writes it, and as layer 1.4 does.
OLD = """\
{0}(ERROR / SPEC): msgNum: -2002613274 - Validation Error: [ {0} ] Object 0: handle = 0x7fecda3eb2a0, \
name = my; name, type = VK_OBJECT_TYPE_COMMAND_BUFFER; Object 1: handle = 0xf56c9b0000000004, \
type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR; | MessageID = 0x88a28be6 | \
vkCmdDraw: parameter infoCount must be greater than 0. The Vulkan spec states: infoCount must be greater \
than 0 (https://www.khronos.org/registry/vulkan/specs/1.3-extensions/html/vkspec.html#{0})
    Objects: 2
        [0] 0x7fecda3eb2a0, type: 6, name: my; name
        [1] 0xf56c9b0000000004, type: 1000150000, name: NULL
"""
NEW = """\
Validation Error: [ {0} ] | MessageID = 0x63ff8904
(Warning - This VUID has now been reported 10 times, which is the duplicate_message_limit value, this will \
be the last time reporting it).
vkCmdDraw(): pInfos[0].scratchData.deviceAddress (0x1000001e0001) must be aligned.
It is not.
The Vulkan spec states: For each element [...] (a multiple) (https://docs.vulkan.org/spec#{0})
Objects: 2
    [0] VkCommandBuffer 0x7fcff17d88b0[my [first] cb]
    [1] VkAccelerationStructureKHR 0x10000000001

"""
# Functions for the scripts of applications.
LOG = f"OTHER, SCRATCH, OLD, NEW = {OTHER!r}, {SCRATCH!r}, {OLD!r}, {NEW!r}" + """
log = open(os.environ["VK_KHRONOS_VALIDATION_LOG_FILENAME"], "w")
def say(text):
    log.write(text)
    log.flush()
"""


class Messages(unittest.TestCase):
    def test_old(self):
        [finding] = read_messages(OLD.format(SCRATCH))
        self.assertEqual(finding, {
            "Type": "Finding", "Layer": "Khronos", "VUID": SCRATCH, "Severity": "Error",
            "MessageID": "0x88a28be6", "Function": "vkCmdDraw",
            "Objects": [{"type": "VkCommandBuffer", "handle": "0x7fecda3eb2a0", "name": "my; name"},
                        {"type": "VkAccelerationStructureKHR", "handle": "0xf56c9b0000000004"}],
            "MainMessage": "vkCmdDraw: parameter infoCount must be greater than 0.",
            "SpecText": "infoCount must be greater than 0",
            "SpecUrl": "https://www.khronos.org/registry/vulkan/specs/1.3-extensions/html/vkspec.html#" + SCRATCH})

    def test_new(self):
        [finding] = read_messages(NEW.format(SCRATCH))
        self.assertEqual(finding, {
            "Type": "Finding", "Layer": "Khronos", "VUID": SCRATCH, "Severity": "Error",
            "MessageID": "0x63ff8904", "Function": "vkCmdDraw",
            "Location": "pInfos[0].scratchData.deviceAddress",
            "Objects": [{"type": "VkCommandBuffer", "handle": "0x7fcff17d88b0", "name": "my [first] cb"},
                        {"type": "VkAccelerationStructureKHR", "handle": "0x10000000001"}],
            "MainMessage": "vkCmdDraw(): pInfos[0].scratchData.deviceAddress (0x1000001e0001) must be "
                           "aligned.\nIt is not.",
            "SpecText": "For each element [...] (a multiple)",
            "SpecUrl": "https://docs.vulkan.org/spec#" + SCRATCH})

    def test_several(self):
        text = NEW.format(OTHER) + OLD.format(SCRATCH) + OLD.format("VUID-third")
        self.assertEqual([one["VUID"] for one in read_messages(text)], [OTHER, SCRATCH, "VUID-third"])
        self.assertEqual(last_heading(text), len(NEW.format(OTHER) + OLD.format(SCRATCH)))

    def test_without_specification_and_objects(self):
        text = "UNASSIGNED-a b(WARN / SPEC): msgNum: 0 - Validation Performance Warning: [ UNASSIGNED-a b ] " \
            "| MessageID = 0x0 | Unused.\n    Objects: 0\nValidation Information: [ WARNING-x ] | MessageID " \
            "= 0x12\nText of a (https://example.org) page.\nObjects: 0\n\n"
        first, second = read_messages(text)
        self.assertEqual((first["Severity"], first["MainMessage"], first["Objects"]), ("Warning", "Unused.", []))
        self.assertEqual((second["Severity"], second["MainMessage"]),
                         ("Info", "Text of a (https://example.org) page."))

    def test_no_message(self):
        for text in ("", "\n", "Validation Layer Info - Logging", "Validation Error: [ VUID-cut"):
            self.assertEqual(read_messages(text), [])


class Settings(Runs):
    def change(self, environment, **options):
        KhronosLog(self.folder, self.folder, **options).change(environment)
        return (self.folder / "vk_layer_settings.txt").read_text(encoding="utf-8").splitlines()

    def test_the_given_file_stays(self):
        (self.folder / "given").mkdir()
        (self.folder / "given/vk_layer_settings.txt").write_text(
            "# a comment\nassay_validation.level = state\nkhronos_validation.log_filename = stdout\n"
            "khronos_validation.report_flags = error,warn\n")
        environment = {"VK_LAYER_SETTINGS_PATH": str(self.folder / "given")}
        lines = self.change(environment)
        self.assertEqual(lines[:3], ["# a comment", "assay_validation.level = state",
                                     "khronos_validation.report_flags = error,warn"])
        pipe = str(self.folder / "khronos.pipe")
        self.assertIn(f"khronos_validation.log_filename = {pipe}", lines)
        self.assertEqual(environment["VK_LAYER_SETTINGS_PATH"], str(self.folder / "vk_layer_settings.txt"))
        self.assertEqual(environment["VK_KHRONOS_VALIDATION_LOG_FILENAME"], pipe)

    def test_file_of_the_working_folder(self):
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        (self.folder / "work").mkdir()
        (self.folder / "work/vk_layer_settings.txt").write_text("assay_validation.level = state\n")
        os.chdir(self.folder / "work")
        self.assertIn("assay_validation.level = state", self.change({}))
        os.chdir(before)

    def test_limit(self):
        key = "VK_KHRONOS_VALIDATION_ENABLE_MESSAGE_LIMIT"
        for is_limited in (True, False):
            environment = {}
            lines = self.change(environment, is_limited=is_limited)
            self.assertEqual(key in environment, not is_limited)
            self.assertEqual("khronos_validation.enable_message_limit = false" in lines, not is_limited)


class CountKhronos(Runs):
    """The manifest of the layer must exist, because assay-run looks for it; nothing loads it."""

    def setUp(self):
        super().setUp()
        (self.folder / "VkLayer_khronos_validation.json").touch()
        self.environment["VK_LAYER_PATH"] = str(self.folder)

    def run_log(self, script, *options):
        return self.run_script(LOG + textwrap.dedent(script), "--count-khronos", *options)

    def test_finding_of_the_khronos_layer(self):
        script = "load(); say(OLD.format(OTHER)); say(NEW.format(OTHER)); end()"
        result = self.expect(self.run_log(script, "--junit", "a.xml", "--sarif", "a.sarif", "--json", "a.json",
                                          "--html", "a.html", "--github"), 99,
                             f"Error: {OTHER} (Khronos layer)",
                             "2 findings (2 by the Khronos layer only) in 1 process")
        self.assertIn(f"title={OTHER} (Khronos layer)::Khronos layer: vkCmdDraw", result.out)
        failures = ElementTree.parse(self.folder / "a.xml").getroot().iter("failure")
        self.assertEqual([one.get("message")[:24] for one in failures], ["Khronos layer: vkCmdDraw"])
        results = self.load("a.sarif")["runs"][0]["results"]
        self.assertEqual([one["properties"] for one in results], [{"reportedBy": "Khronos layer"}] * 2)
        self.assertEqual([one["Layer"] for one in self.load("a.json")["new"]], ["Khronos"] * 2)
        self.assertIn("Khronos layer", self.read("a.html"))

    def test_both_report_it(self):
        """In the same command, or about the same object."""
        for members in ("Function='vkCmdDraw'",
                        "Objects=[{'type': 'VkAccelerationStructureKHR', 'handle': '0x10000000001'}]",
                        "Objects=[{'type': 'VkCommandBuffer', 'handle': '0x1', 'name': 'my [first] cb'}]",
                        "also=[OTHER], vuid='VUID-x', Function='vkCmdDraw'"):
            with self.subTest(members):
                names = members if "vuid=" in members else f"vuid=OTHER, {members}"
                script = f"load(); say(NEW.format(OTHER)); find({names}); end()"
                self.expect(self.run_log(script), 99, " (both layers)", "1 finding in 1 process")

    def test_they_report_different_things(self):
        """Another id, another command, or other objects that have names."""
        for members in ("'VUID-x', Function='vkCmdDraw'", "OTHER, Function='vkCmdDispatch'", "OTHER",
                        "OTHER, Objects=[{'type': 'VkDevice', 'handle': '0x7fcff17d88b0'}]"):
            with self.subTest(members):
                script = f"load(); say(NEW.format(OTHER)); find({members}); end()"
                self.expect(self.run_log(script), 99, "2 findings (1 by the Khronos layer only)")
        named = OLD.replace("; Object 1: handle = 0xf56c9b0000000004,", "; Object 1: handle = 0x5, name = rock,")
        script = f"""
            load(); say({named!r}.format(OTHER)); end()
            find(OTHER, Function='vkCmdDraw', Objects=[
                {{'type': 'VkAccelerationStructureKHR', 'handle': '0x6', 'name': 'tree'}}])"""
        self.expect(self.run_log(script), 99, "2 findings (1 by the Khronos layer only)")

    def test_baseline(self):
        script = "load(); say(NEW.format(OTHER)); end()"
        self.expect(self.run_log(script, "--write-baseline", "known.txt"), 0, "wrote 1 line")
        self.assertIn(f"{OTHER}@my [[]first] cb", self.read("known.txt"))
        self.expect(self.run_log(script, "--baseline", "known.txt"), 0, "1 known finding")
        self.expect(self.run_log("load(); say(NEW.format('VUID-new')); end()", "--baseline", "known.txt"), 99)

    def test_warnings_do_not_count(self):
        script = "load(); say(NEW.format(OTHER).replace('Error', 'Warning')); end()"
        self.expect(self.run_log(script), 0, "0 findings", "warning (Khronos layer): vkCmdDraw()")

    def test_layer_is_not_loaded(self):
        self.expect(self.run_script("load(); end()", "--count-khronos"), 98, "the Khronos layer was not loaded")
        self.expect(self.run_log("load(); end()"), 0)
        self.expect(self.run_script("load(); end()", "--with-khronos"), 0)

    def test_merge(self):
        for script in ("load(); say(NEW.format(OTHER)); end()", "load(); find(OTHER, Function='vkCmdDraw'); end()"):
            self.run_log(script, "--record", "records")
        self.expect(self.run_words("--merge", "records"), 99, "2 findings (1 by the Khronos layer only)")
        self.run_script("load(); end()", "--count-khronos", "--record", "others")
        self.expect(self.run_words("--merge", "others"), 98, "the Khronos layer was not loaded")

    def test_many_messages(self):
        """More than the pipe holds, by several processes at once."""
        script = """
            load()
            os.fork()
            os.fork()
            for i in range(500):
                say(NEW.format(f"VUID-{os.getpid()}-{i}"))
            try:
                while True: os.wait()
            except ChildProcessError:
                end()"""
        self.expect(self.run_log(script), 99, "2,000 findings")

    def test_live(self):
        script = """
            load(); say(NEW.format(OTHER)); time.sleep(0.5); find(SCRATCH, Function='vkCmdDraw')
            say(NEW.format(SCRATCH)); time.sleep(0.5); end()"""
        result = self.expect(self.run_log(script, "--live"), 99, f"Error: {OTHER} (Khronos layer)",
                             "2 findings (1 by the Khronos layer only)")
        self.assertEqual(result.err.count(f"Error: {SCRATCH}"), 1)

    def test_stop_at_first(self):
        self.expect(self.run_log("load(); say(NEW.format(OTHER)); time.sleep(600)", "--stop-at-first"), 99,
                    "the first finding has ended the run")

    def test_process_that_goes_on(self):
        """assay-run does not wait for it after a signal; what it writes later must not end it."""
        script = """
            load()
            if os.fork():
                time.sleep(0.3)
                os.kill(os.getppid(), signal.SIGTERM)
                sys.exit(0)
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            sys.stdout.close(); sys.stderr.close()
            while os.path.exists(log.name): time.sleep(0.05)
            time.sleep(0.2)
            for i in range(200): say(NEW.format(OTHER))
            open("survived", "w").close()"""
        self.run_log(script)
        end = time.monotonic() + 20
        while not (self.folder / "survived").exists() and time.monotonic() < end:
            time.sleep(0.05)
        self.assertTrue((self.folder / "survived").exists())

    def test_damaged_log(self):
        script = "load(); say('no heading\\n' + NEW.format(OTHER)[20:]); say('Validation Error: [ VUID-cut'); end()"
        self.expect(self.run_log(script), 0)

    def test_schema_of_run(self):
        record = self.write_record(header(), name="run/7.jsonl").parent
        (record / "run.json").write_text('{"command": ["app"], "status": 0, "khronos": false}')
        self.expect(self.run_words("--merge", "run"), 98, "the Khronos layer was not loaded")
        (record / "run.json").write_text('{"command": ["app"], "status": 0}')  # of an older assay-run
        self.expect(self.run_words("--merge", "run"), 0)
        self.assertFalse(pathlib.Path(record / "khronos.jsonl").exists())


if __name__ == "__main__":
    main()
