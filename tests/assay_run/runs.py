# SPDX-License-Identifier: Apache-2.0
"""What the tests of assay-run share: runs of it, and records as the layer writes them."""

import collections
import json
import os
import pathlib
import runpy
import sys
import tempfile
import textwrap
import traceback
import unittest

try:
    import jsonschema
except ImportError:
    jsonschema = None

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ASSAY_RUN = ROOT / "scripts/assay-run"
SCHEMA = ROOT / "json/findings.schema.json"
RUN = runpy.run_path(str(ASSAY_RUN), run_name="assay_run_of_tests")["main"]
needs_jsonschema = unittest.skipIf(jsonschema is None, "python3-jsonschema is not installed")
VUID = "VUID-vkCmdBuildAccelerationStructuresKHR-infoCount-arraylength"
TIME = "2026-11-22T18:00:00.000001Z"
NASTY = "\"\\</script><b>&'\x1b[31m\x00\x07é🦆\u2028%{{data}}]]>::warning::x\n"

# A layer that cannot be loaded in Python: applications of the tests write the record by themselves.
LAYER = f"TIME, VUID = {TIME!r}, {VUID!r}" + """
import json, os, re, signal, sys, time
def write(line):
    name = re.sub("%(.)", lambda match: {"p": str(os.getpid())}.get(match[1], match[1]),
                  os.environ["VK_ASSAY_VALIDATION_LOG_FILENAME"])
    text = line if isinstance(line, str) else json.dumps({"pid": os.getpid(), "time": TIME, **line}) + "\\n"
    file = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    os.write(file, text.encode())
    os.close(file)
def load():
    write({"Type": "Header", "version": 1, "Layer": "VK_LAYER_ASSAY_validation", "LayerVersion": "0.2.0",
           "RegistryVersion": "1.4.363", "Application": {"Name": "app"}, "Settings": {"level": "state"}})
def find(vuid=VUID, **members):
    write({"Type": "Finding", "Severity": "Error", "VUID": vuid, "MessageID": "0x1", "Objects": [],
           "MainMessage": "infoCount is 0.", **members})
def end(**members):
    write({"Type": "Summary", "Findings": {}, "HeldBack": {}, "Unchecked": [], **members})
"""


def finding(vuid=VUID, **members):
    return {"Type": "Finding", "pid": 7, "time": TIME, "Severity": "Error", "VUID": vuid,
            "MessageID": "0x1", "Objects": [], "MainMessage": "infoCount is 0.", **members}


def header(**members):
    return {"Type": "Header", "pid": 7, "time": TIME, "version": 1, "Layer": "VK_LAYER_ASSAY_validation",
            "LayerVersion": "0.2.0", "RegistryVersion": "1.4.363", "Application": {"Name": "app"},
            "Settings": {"level": "execution"}, **members}


Result = collections.namedtuple("Result", "status out err")


def become_assay_run(words, folder, environment, *files):
    """Goes on as a process that has just been started: in a folder, and with files for its output."""
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    tempfile.tempdir = None  # TMPDIR may be another
    for number, file in enumerate(files, 1):
        os.dup2(file.fileno(), number)
    sys.stdout, sys.stderr = (open(number, "w", encoding=environment.get("PYTHONIOENCODING", "utf-8"))
                              for number in (1, 2))
    sys.argv = [str(ASSAY_RUN), *words]
    try:
        sys.exit(RUN())
    except SystemExit as end:
        status = end.code or 0
    except BaseException:  # pylint: disable=broad-exception-caught
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


class Runs(unittest.TestCase):
    """A folder of its own for each test."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="assay-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {key: value for key, value in os.environ.items()
                            if not key.startswith("VK_")}

    def run_words(self, *words, **environment):
        """Runs assay-run in a copy of this process, which has loaded its modules: starting takes longer than
        most runs."""
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            process = os.fork()
            if process == 0:
                become_assay_run(map(str, words), self.folder, {**self.environment, **environment}, out, err)
            status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
            texts = []
            for file in (out, err):
                file.seek(0)
                texts.append(file.read().decode("utf-8", "backslashreplace"))
        self.assertNotIn("Traceback", texts[1])
        return Result(status, *texts)

    def run_script(self, script, *options, **environment):
        """Runs a script of Python that has the functions of LAYER."""
        return self.run_words(*options, "--", sys.executable, "-B", "-S", "-c",
                              LAYER + textwrap.dedent(script), **environment)

    def expect(self, result, status, *words):
        """Returns a result that has this status and these words on standard error."""
        self.assertEqual(result.status, status, result.err)
        for word in words:
            self.assertIn(word, result.err)
        return result

    def read(self, name):
        return (self.folder / name).read_text(encoding="utf-8")

    def load(self, name):
        return json.loads(self.read(name))

    def write_record(self, *lines, name="7.jsonl"):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        return path


def main():
    """Runs the tests of the program. If one is left out because something is missing, the exit status
    says so (77), and CTest counts the program as skipped."""
    result = unittest.main(module="__main__", argv=sys.argv[:1], exit=False).result
    if not result.wasSuccessful():
        sys.exit(1)
    for test, reason in result.skipped:
        print(f"skipped: {test}: {reason}")
    sys.exit(77 if result.skipped else 0)
