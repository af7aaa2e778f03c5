# SPDX-License-Identifier: Apache-2.0
"""Setting capture end to end: programs under the layer, on the null driver. Their captures are read, and checked for all
that docs/capture.md says of them, without a library of the project's.

layer_test.py PROGRAMS"""

import ast
import json
import multiprocessing.pool
import os
import pathlib
import random
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

try:
    import jsonschema
except ImportError:
    jsonschema = None

PROGRAMS = sys.argv[1]
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCHEMA = json.loads((ROOT / "json/capture.schema.json").read_text("utf-8"))
SIZES = {"f2": 2, "f4": 4, "f8": 8, "i1": 1, "i2": 2, "i4": 4, "u1": 1, "u2": 2, "u4": 4, "u8": 8}
FILES = ROOT / "tests/programs"
MIB = 1 << 20
KILLS = int(os.environ.get("ASSAY_TEST_KILLS") or 5)
# An application that builds, updates in place and from another structure, and compacts, by two queues in turn.
TURN = "; ".join(
    "build B{0}; $ALL; build B{0} update; $ALL; build B{1}; $ALL; build B{1} update src B{0}; $ALL; build B{2}; $ALL; "
    "compact B{0} > B{2}; $ALL".format(i, i + 1, i + 2) for i in (0, 3, 6, 9))
BUILDS_A_SUBMISSION = TURN.count("build")
APPLICATION = """
unjudged
case an application
repeat {} {turn}; submit q0; host wait idle; {turn}; submit q1; host wait idle
"""


def size_of(descr):
    """Returns the bytes of an element of a dtype, as its header describes it."""
    if isinstance(descr, str):
        return SIZES[descr[1:]]
    total = 0
    for member in descr:
        count = 1
        for columns in member[2] if len(member) > 2 else ():
            count *= columns
        total += size_of(member[1]) * count
    return total


def read_array(path):
    """Returns (dtype, shape, bytes) of a file of NumPy's format 1.0, all of it."""
    data = path.read_bytes()
    assert data[:8] == b"\x93NUMPY\x01\x00", path
    size = 10 + struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:size].decode("ascii"))
    assert size % 64 == 0 and data[size - 1] == 10 and not header["fortran_order"], path
    count = 1
    for length in header["shape"]:
        count *= length
    assert len(data) - size == count * size_of(header["descr"]), path
    return header["descr"], header["shape"], data[size:]


def validators():
    """Returns a validator for each type of line; none without python3-jsonschema."""
    if jsonschema is None:
        return {}
    return {name.capitalize(): jsonschema.Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]})
            for name in (entry["$ref"].rpartition("/")[2] for entry in SCHEMA["oneOf"])}


def shape_of(value):
    """Returns the members and types of a value without what they are."""
    if isinstance(value, dict):
        return tuple((key, shape_of(value[key])) for key in sorted(value))
    if isinstance(value, list):
        return tuple({shape_of(element): None for element in value})
    return type(value).__name__


class Capture:
    """A capture that was read and checked. A killed process may leave half a line at the end."""

    def __init__(self, folder, was_killed=False):
        self.folder = pathlib.Path(folder)
        lines = (self.folder / "builds.jsonl").read_text("utf-8").split("\n")
        self.cut = lines.pop()
        assert was_killed or not self.cut, f"{folder}: half a line"
        self.lines = [json.loads(line) for line in lines]
        self.arrays = {}
        self.check_lines()
        self.check_files(was_killed)

    def of_type(self, *types):
        return [line for line in self.lines if line["Type"] in types]

    def check_lines(self):
        schema, shapes = validators(), set()
        known = {"memory": set(), "buffer": set(), "structure": set()}
        number = 0
        for line in self.lines:
            shape = shape_of(line)
            if line["Type"] in schema and shape not in shapes:  # validating takes a hundred times as long
                schema[line["Type"]].validate(line)
                shapes.add(shape)
            self.check_names(line, known)
            if line["Type"].lower() in known:
                name = line[line["Type"].lower()]
                assert name not in known[line["Type"].lower()], line
                known[line["Type"].lower()].add(name)
            if "n" in line:
                assert line["n"] == number + 1, line
                number += 1
        assert not self.lines or [line["Type"] for line in self.lines[:2]] == ["Capture", "Device"][:len(self.lines)]

    def check_names(self, line, known):
        """A line names only what earlier lines describe."""
        if line["Type"] == "Buffer":
            assert line.get("memory") is None or line["memory"] in known["memory"], line
        elif line["Type"] == "Structure":
            assert line.get("buffer") is None or line["buffer"] in known["buffer"], line
        for reference in line.get("references", ()):
            assert reference["structure"] in known["structure"], line
        for geometry in line.get("geometry", ()):
            for data in geometry["inputs"]:
                assert data.get("buffer") is None or data["buffer"] in known["buffer"], line
                if "data" in data:
                    self.check_array(data)

    def check_array(self, data):
        if data["data"] not in self.arrays:
            self.arrays[data["data"]] = (*read_array(self.folder / "data" / f"{data['data']}.npy"), data["stride"])
        shape = self.arrays[data["data"]][1]
        rows = min(data["count"], 1) if data["stride"] == 0 else data["count"]
        assert 0 < shape[0] <= rows, data

    def check_files(self, was_killed):
        """Each file belongs to a line, unless the process was killed in between."""
        files = {path.stem for path in (self.folder / "data").glob("*.npy")}
        assert was_killed or files == set(self.arrays), self.folder
        names = {path.name for path in (self.folder / "data").iterdir() if path.suffix != ".npy"}
        assert names <= ({"part"} if was_killed else set()), names


class CaptureTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def command(self, builds, **settings):
        """Returns the arguments of subprocess.run() for an application with at least so many builds."""
        programs = self.folder / "programs"
        (programs / "capture").mkdir(parents=True, exist_ok=True)
        (programs / "common.cases").write_text("define ALL barrier all:memory_write > all:memory_read|memory_write\n")
        (programs / "capture/application.cases").write_text(
            APPLICATION.format(-(-builds // (2 * BUILDS_A_SUBMISSION)), turn=TURN))
        return {"args": [PROGRAMS, "null", "capture"], "env": {
            **os.environ, "ASSAY_PROGRAMS": str(programs), "VK_ASSAY_VALIDATION_LEVEL": "content",
            "VK_ASSAY_VALIDATION_HAZARDS": "false", "VK_ASSAY_VALIDATION_DEBUG_ACTION": "log",
            **{f"VK_ASSAY_VALIDATION_{key.upper()}": str(value) for key, value in settings.items()}}}

    def run_application(self, capture, builds=200, **settings):
        """Returns what it and the layer print."""
        return subprocess.run(**self.command(builds, capture=capture, **settings), text=True, stderr=subprocess.PIPE,
                              stdout=subprocess.PIPE, check=True, timeout=300)

    def test_programs(self):
        """Whatever programs do, their captures are as docs/capture.md says."""
        files = [str(path.relative_to(FILES).with_suffix("")) for folder in ("snapshots", "life", "wild")
                 for path in FILES.glob(f"{folder}/*.cases")
                 if path.stem not in ("common", "frames")]  # frames repeat few builds hundreds of times

        def play(file):  # several at a time, because some wait
            subprocess.run([PROGRAMS, "null", file], env={**os.environ, "VK_ASSAY_VALIDATION_CAPTURE": f"{self.folder}/p%p"},
                           check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=300)
        with multiprocessing.pool.ThreadPool(4) as pool:
            pool.map(play, files)
        captures = [Capture(path) for path in self.folder.iterdir()]
        builds = [line for capture in captures for line in capture.of_type("Build")]
        geometries = [geometry for build in builds for geometry in build.get("geometry", ())]
        self.assertLessEqual({"triangles", "aabbs", "instances", "spheres"}, {part["type"] for part in geometries})
        for role in ("centers", "radii", "displacement vectors", "displacement biases"):
            inputs = [part for geometry in geometries for part in geometry["inputs"] if part["role"] == role]
            self.assertEqual([part for part in inputs if "data" not in part], [])
            self.assertTrue(inputs)
        types = {(rows[at], any(rows[at + 8:at + 152])) for capture in captures
                 for _, shape, rows, stride in capture.arrays.values()
                 for at in range(0, len(rows), 152) if (stride, len(rows)) == (8, 152 * shape[0])}  # behind pointers
        self.assertEqual(types, {(0, True), (1, True), (2, True)})
        for command in ("vkCmdBuildAccelerationStructuresKHR", "vkCmdBuildMicromapsEXT"):
            self.assertTrue(any(part["role"] == "micromap data" and "data" in part for build in builds
                                if build["command"] == command
                                for geometry in build.get("geometry", ()) for part in geometry["inputs"]))
        self.assertGreater(sum("missing" not in build for build in builds), len(builds) // 2)
        self.assertEqual([build for build in builds if "build" not in build and build["type"] != "micromap"], [])
        self.assertLessEqual({"Copy", "Destroyed"}, {line["Type"] for capture in captures for line in capture.lines})

    def test_application(self):
        self.run_application(self.folder / "all")
        capture = Capture(self.folder / "all")
        self.assertGreater(len(capture.of_type("Build")), 100)
        self.assertEqual(capture.of_type("End")[0]["why"], "the device was destroyed")
        self.assertEqual([build for build in capture.of_type("Build") if "missing" in build], [])
        # All builds read the same few arrays, and each is written once.
        self.assertLess(len(capture.arrays), 10)
        self.assertTrue((self.folder / "all/findings.jsonl").is_file())

    def test_second_run(self):
        self.run_application(self.folder / "again")
        before = (self.folder / "again/builds.jsonl").read_bytes()
        self.assertIn("cannot be written (it has a capture). Nothing is captured.",
                      self.run_application(self.folder / "again").stderr)
        self.assertEqual((self.folder / "again/builds.jsonl").read_bytes(), before)

    def test_no_permission(self):
        (self.folder / "file").write_text("")
        shown = self.run_application(self.folder / "file/capture").stderr
        self.assertEqual(shown.count("Nothing is captured."), 1, shown)

    def test_limit(self):
        shown = self.run_application(self.folder / "limit", builds=2000, capture_limit_mib=1).stderr
        self.assertEqual(shown.count("capture_limit_mib is reached. The application goes on."), 1, shown)
        capture = Capture(self.folder / "limit")
        self.assertEqual(capture.lines[-1]["why"], "capture_limit_mib was reached")
        self.assertLess(sum(path.stat().st_size for path in (self.folder / "limit").rglob("*") if path.is_file() and
                            path.name != "findings.jsonl"), MIB + 1000)

    def test_full_disk(self):
        """As a limit of the sizes of files behaves."""
        shown = subprocess.run(
            **self.command(1000, capture=self.folder / "disk"), text=True, timeout=300, check=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (MIB // 4, MIB // 4))).stderr
        self.assertEqual(shown.count("ends here: File too large. The application goes on."), 1, shown)
        Capture(self.folder / "disk", was_killed=True)

    def test_none(self):
        """Vulkan Configurator writes all settings."""
        shown = self.run_application("none", builds=20, capture_from="none", capture_until="none").stderr
        self.assertNotIn("capture", shown)
        self.assertFalse(pathlib.Path("none").exists())

    def test_low_level(self):
        shown = self.run_application(self.folder / "low", level="execution").stderr
        self.assertIn("capture needs level = content. Nothing is captured.", shown)
        self.assertFalse((self.folder / "low").exists())

    def submissions_of(self, folder):
        return {line["submission"] for line in Capture(folder).of_type("Build") if "submission" in line}

    def test_range(self):
        self.run_application(self.folder / "part", builds=400, capture_from="submission:03", capture_until="submission:5")
        self.assertEqual(self.submissions_of(self.folder / "part"), {3, 4, 5})
        self.assertEqual(Capture(self.folder / "part").lines[-1]["why"], "capture_until was reached")

    def test_kept(self):
        """Copies and updates in the range are of structures that were built before."""
        self.run_application(self.folder / "bare", builds=400, capture_from="submission:3")
        self.run_application(self.folder / "kept", builds=400, capture_from="submission:3", capture_keep="true")
        bare, kept = Capture(self.folder / "bare"), Capture(self.folder / "kept")
        self.assertEqual({line.get("missing", "") != "" for line in kept.of_type("Structure")}, {False})
        self.assertGreaterEqual(len(kept.of_type("Build")), len(bare.of_type("Build")))

    def test_bad_points(self):
        for point in ("frame:", "frame:x", "submission:-1", "label:", "12"):
            shown = self.run_application(self.folder / "points", builds=20, capture_from=point).stderr
            self.assertIn("capture_from", shown)
            self.assertIn("frame:N, submission:N or label:TEXT", shown)
            subprocess.run(["rm", "-rf", self.folder / "points"], check=True)

    def test_killed(self):
        """What is written when the process is killed is valid."""
        seed = int(os.environ.get("ASSAY_TEST_SEED") or 1)
        numbers = random.Random(seed)
        begin = time.monotonic()
        self.run_application(self.folder / "whole", builds=500)
        whole = time.monotonic() - begin
        killed = 0
        for attempt in range(KILLS):
            folder = self.folder / f"killed{attempt}"
            process = subprocess.Popen(**self.command(500, capture=folder), stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
            time.sleep(whole * numbers.random())
            process.send_signal(signal.SIGKILL)
            killed += process.wait() == -signal.SIGKILL
            if (folder / "builds.jsonl").exists():
                Capture(folder, was_killed=True)
        self.assertGreater(killed, 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
