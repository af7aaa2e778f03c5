# SPDX-License-Identifier: Apache-2.0
"""assay-scene replay, minimize, and report with a device, and assay-run --scene, on captures of the demo: on lavapipe,
and with mistakes on the null driver.

replay_test.py ASSAY_SCENE DEMO LAYER_FOLDER NULL_MANIFEST LAVAPIPE_MANIFEST CASE"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from collections import Counter

from captures import IDENTITY, Capture, scene as small_scene

SCENE, DEMO, LAYERS, NULL, LAVAPIPE = sys.argv[1:6]
ASSAY_RUN = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts/assay-run"
# What replays cannot repeat: freed memory, a render pass, and a command buffer that does not record.
NOT_REPLAYED = {"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03707",
                "VUID-vkCmdBuildAccelerationStructuresKHR-renderpass",
                "VUID-vkCmdBuildAccelerationStructuresKHR-commandBuffer-recording"}
# In the demo the address of a structure without memory is unknown, so that any reference may be to it.
ONLY_REPLAYED = {"VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12281"}


def environment(manifest, **settings):
    return {**os.environ, "VK_DRIVER_FILES": manifest, "VK_ICD_FILENAMES": manifest, "VK_LAYER_PATH": LAYERS,
            **{f"VK_ASSAY_VALIDATION_{key.upper()}": str(value) for key, value in settings.items()}}


def capture(manifest, folder, *arguments, **settings):
    """Captures a run of the demo, whose exit status does not count."""
    result = subprocess.run([DEMO, "--no-picture", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True, timeout=600, check=False,
                            env={**environment(manifest, level="content", capture=folder, hazards="false", **settings),
                                 "VK_INSTANCE_LAYERS": "VK_LAYER_ASSAY_validation"})
    assert (folder / "builds.jsonl").is_file(), result.stdout + result.stderr


def scene(manifest, *arguments, plan="", layers="", **settings):
    """Runs assay-scene, itself under `layers`; `plan` is a call of the null driver that fails."""
    return subprocess.run([SCENE, *map(str, arguments)], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          env={**environment(manifest, **settings), "NULL_DRIVER_FAILS": plan,
                               "VK_INSTANCE_LAYERS": layers}, timeout=600, check=False)


def assay_run(*options):
    """Runs the demo on lavapipe."""
    return subprocess.run([ASSAY_RUN, *options, "--", DEMO, "--no-picture"], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, env=environment(LAVAPIPE), timeout=600, check=False)


def arrays(folder):
    return {path.name for path in (folder / "data").iterdir()}


def read_lines(path):
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def lines(folder, kind):
    return [line for line in read_lines(folder / "builds.jsonl") if line["Type"] == kind]


def what_is_built(build):
    """A line without what a replay chooses: addresses, numbers, and the contents of instances, which have addresses."""
    kept = {key: build.get(key) for key in ("mode", "type", "flags", "primitives", "size", "dst_name", "src_name")}
    kept["geometry"] = [
        {**geometry, "inputs": [{key: value for key, value in data.items() if key not in ("address", "buffer")
                                 and (key, data["role"]) != ("data", "instances")} for data in geometry["inputs"]]}
        for geometry in build["geometry"]]
    return kept


class Case(unittest.TestCase):
    """A folder for all tests."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)


class Replay(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.mistakes = cls.folder / "mistakes"
        capture(NULL, cls.mistakes, "--execute")

    def test_mistakes_are_found_again(self):
        found = read_lines(self.mistakes / "findings.jsonl")
        before = Counter(finding["VUID"] for finding in found if finding["Severity"] == "Error")
        result = scene(NULL, "replay", "--layer", self.mistakes, hang_seconds="soon", hazards="true")
        after = Counter(line.split()[1] for line in result.stdout.splitlines() if line.startswith("finding: "))
        self.assertEqual(set(before - after), NOT_REPLAYED)
        self.assertEqual(set(after - before), ONLY_REPLAYED | {"ASSAY-warning"})
        names = {line.split(" ", 2)[1]: line for line in result.stdout.splitlines() if line.startswith("finding: ")}
        self.assertIn('"small BLAS"', names["VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-10126"])
        self.assertEqual(result.returncode, 2)  # four builds have no data: in the render pass, for instance, nothing is copied
        self.assertIn("not replayed, 3 more: a part of its data is not in the capture\n", result.stdout)

    def test_minimize(self):
        """One box of 480 is reversed in one build of some fifty; another has scratch data at a wrong address."""
        for finding in ("VUID-VkAccelerationStructureGeometryAabbsDataKHR-stride-03545",
                        "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-03710"):
            small = self.folder / finding
            result = scene(NULL, "minimize", self.mistakes, small, "--finding", finding)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("left: 1 commands, 1 geometries, 1 primitives", result.stdout)
            self.assertEqual((len(lines(small, "Build")), len(lines(small, "Structure"))), (1, 1))
            self.assertIn(f"finding: {finding}", scene(NULL, "replay", "--layer", small).stdout)

    def test_minimize_geometries(self):
        """One bad index among twenty builds of three geometries of 300 triangles each."""
        count, size, offset = 300, 1 << 24, 1 << 19  # of indices, behind the vertices
        finding = "VUID-VkAccelerationStructureBuildRangeInfoKHR-maxVertex-10774"
        made, small = Capture(self.folder / "many"), self.folder / "small_many"
        made.add("Memory", memory=2, size=size)
        made.add("Buffer", buffer=2, name="structures", memory=2, memory_offset=0, size=size, usage="0x120000")
        vertices = [(i % 100, i // 100, i % 7) for i in range(1000)]
        for build in range(20):
            made.add("Structure", structure=10 + build, handle=hex(0x2000 + build), type="bottom level", buffer=2,
                     offset=0, size=size)
            geometries = []
            for number in range(3):
                indices = [(7 * i + build) % 1000 for i in range(3 * count)]
                if (build, number) == (13, 1):
                    indices[2 * count] = 1000
                geometries.append(made.triangles(vertices, indices))
                geometries[-1]["inputs"][1]["offset"] = offset * (1 + number)
            made.build(10 + build, *geometries, call=build + 1, info=0)
        result = scene(NULL, "minimize", made.write(), small, "--finding", finding)
        self.assertEqual((result.returncode, result.stderr), (0, ""), result.stdout)
        self.assertIn("left: 1 commands, 1 geometries, 1 primitives", result.stdout)
        self.assertEqual([build["dst_id"] for build in lines(small, "Build")], [23])

    def test_minimize_nothing(self):
        result = scene(NULL, "minimize", self.mistakes, self.folder / "none", "--finding", "VUID-not-there")
        self.assertEqual(result.returncode, 2)
        self.assertIn("the replay of the whole capture does not give VUID-not-there", result.stderr)
        self.assertFalse((self.folder / "none").exists())

    def test_buffers_without_their_places(self):
        """A buffer that cannot lie where it lay, or lay nowhere, has memory of its own."""
        moved = self.folder / "moved"
        shutil.copytree(self.mistakes, moved)
        made = [json.loads(line) for line in (moved / "builds.jsonl").read_text("utf-8").splitlines()]
        buffers = [line for line in made if line["Type"] == "Buffer" and "memory_offset" in line]
        for buffer in buffers[::2]:
            buffer["memory_offset"] += 1
        for buffer in buffers[1::2]:
            del buffer["memory"]
        next(line for line in made if line["Type"] == "Memory")["size"] = 1 << 24  # room for all of them
        (moved / "builds.jsonl").write_text("".join(json.dumps(line) + "\n" for line in made), "utf-8")
        self.assertGreater(len(buffers), 2)
        before, after = (scene(NULL, "replay", "--layer", folder) for folder in (self.mistakes, moved))
        self.assertEqual(after.returncode, before.returncode)
        self.assertEqual(after.stdout.replace(str(moved), str(self.mistakes)), before.stdout)

    def test_dump_to_a_file(self):
        (self.folder / "file").touch()
        for path in (self.folder / "file", self.folder / "file/below"):
            result = scene(NULL, "replay", self.mistakes, "--dump", path)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"assay-scene: {path}: ", result.stderr)

    def test_arguments(self):
        for arguments, text in ((["replay"], "name a capture"), (["replay", "a", "b"], "one argument too many: b"),
                                (["replay", "x", "--repeat", "0"], "not a value of an option: 0"),
                                (["info", "x", "--layer"], "unknown option: layer"),
                                (["minimize", "x", "y"], "name a finding"), (["minimize", "x"], "name the folder"),
                                (["replay", str(self.folder / "missing")], "missing")):
            result = scene(NULL, *arguments)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertIn(text, result.stderr)

    def test_what_is_not_replayed(self):
        made = small_scene(self.folder / "obstacles")
        triangles = made.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [0, 1, 2], matrix=(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0))
        made.build(1, triangles)
        del made.lines[-1]["dst_id"]
        made.build(1, triangles, mode="update")
        made.build(1, missing="memory ran out")
        made.build(1, triangles, flags=0x20)
        made.build(1, {**triangles, "type": "spheres", "inputs": []})
        made.build(4, made.instances([(IDENTITY, 1)], arrayOfPointers=True), kind="top level",
                   references=[{"reference": "0x1", "structure": 1}])
        result = scene(NULL, "replay", made.write())
        self.assertEqual(result.returncode, 2)
        self.assertIn("built: 5; copied: 1; not replayed: 5\n", result.stdout)
        for reason in ("its structure is not in the capture", "the structure that it updates is not in the capture",
                       "memory ran out", "motion is not replayed", "geometries of this type are not replayed"):
            self.assertIn(f": {reason}\n", result.stdout)

    def test_device_fails(self):
        """Whichever call of the device fails, the replay and the report say so."""
        calls = {"vkCreateDevice": [1], "vkCreateCommandPool": [1], "vkAllocateCommandBuffers": [1],
                 "vkCreateBuffer": [1, 3], "vkBeginCommandBuffer": [1, 2], "vkEndCommandBuffer": [1, 2],
                 "vkQueueSubmit": [1, 2], "vkQueueWaitIdle": [1, 2], "vkCreateAccelerationStructureKHR": [1, 2],
                 "vkCreateQueryPool": [2]}
        of_reports = {**calls, "vkAllocateMemory": [2], "vkMapMemory": [2], "vkBindBufferMemory": [2],
                      "vkCreateDescriptorSetLayout": [1], "vkCreatePipelineLayout": [1], "vkCreateShaderModule": [1],
                      "vkCreateComputePipelines": [1], "vkCreateDescriptorPool": [1], "vkAllocateDescriptorSets": [1]}
        calls_of_replays = {**calls, "vkGetQueryPoolResults": [2]}  # a report leaves out the time
        report = self.folder / "device.json"
        small_scene(self.folder / "small_scene").write()
        for command, rows in ((["replay", self.mistakes, "--dump", self.folder / "failed"], calls_of_replays),
                              (["report", self.folder / "small_scene", "--json", report, "--rays", 20, "--device", "null"],
                               of_reports)):
            for name, numbers in rows.items():
                for number in numbers:
                    with self.subTest(command=command[0], call=name, number=number):
                        result = scene(NULL, *command, plan=f"{name} {number} -2")
                        said = result.stderr if command[0] == "replay" else json.loads(report.read_text())["device"]["missing"]
                        self.assertIn(f"{name} returned VK_ERROR_OUT_OF_DEVICE_MEMORY", said)
                        self.assertEqual(result.returncode, 2 if command[0] == "replay" else 0)

    def test_no_driver(self):
        result = scene("/nonexistent.json", "replay", self.mistakes)
        self.assertEqual(result.returncode, 2)
        self.assertIn("found no driver", result.stderr)
        result = subprocess.run([SCENE, "replay", "--layer", str(self.mistakes)], text=True, stderr=subprocess.PIPE,
                                stdout=subprocess.PIPE, env={**environment(NULL), "VK_LAYER_PATH": "/nonexistent"},
                                check=False)
        self.assertIn("found no VK_LAYER_ASSAY_validation", result.stderr)


class Demo(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.demo = cls.folder / "demo"
        capture(LAVAPIPE, cls.demo)

    def test_demo(self):
        dump = self.folder / "dump"
        result = scene(LAVAPIPE, "replay", self.demo, "--time", "--repeat", 2, "--dump", dump)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("built: 4; copied: 1; not replayed: 0", result.stdout)
        self.assertIn("  twisted BLAS\n", result.stdout)
        self.assertEqual({path.name for path in dump.iterdir()},
                         {f"{structure['structure']}.bin" for structure in lines(self.demo, "Structure")})

    def test_what_was_built_before_is_no_mistake(self):
        """The first build of the demo, of what its instances refer to, is before this capture."""
        later = self.folder / "later"
        capture(LAVAPIPE, later, capture_from="submission:2")
        self.assertTrue(any("missing" in structure for structure in lines(later, "Structure")))
        result = scene(LAVAPIPE, "replay", later, "--layer")
        self.assertIn("it needs structures that were not built in the capture", result.stdout)
        self.assertIn("findings: 0", result.stdout)
        self.assertEqual(result.returncode, 2)

    def test_kept(self):
        """With capture_keep the same capture has what was built before, too: as much as the whole one."""
        kept = self.folder / "kept"
        capture(LAVAPIPE, kept, capture_from="submission:2", capture_keep="true")
        self.assertFalse(any("missing" in structure for structure in lines(kept, "Structure")))
        self.expect_same_builds(kept, self.demo)
        result = scene(LAVAPIPE, "replay", kept, "--layer")
        self.assertIn("built: 4; copied: 1; not replayed: 0", result.stdout)
        self.assertIn("findings: 0", result.stdout)

    def test_hits(self):
        """lavapipe misses some hits and doubles others: those of the demo and of the replay are the same."""
        compares = {"compare_rays": 100, "duplicate_message_limit": 0, "log_format": "json", "debug_action": "log"}
        logs = [self.folder / name for name in ("before.jsonl", "after.jsonl")]
        capture(LAVAPIPE, self.folder / "compared", log_filename=logs[0], **compares)
        result = scene(LAVAPIPE, "replay", self.demo, "--compare", log_filename=logs[1], **compares)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        before, after = ([re.sub(" Command buffer .*", "", line["MainMessage"]) for line in read_lines(log)
                          if line.get("VUID", "").startswith("ASSAY-compare-")] for log in logs)
        self.assertGreater(len(before), 0)
        self.assertEqual(before, after)

    def test_wild_reference(self):
        wild = self.folder / "wild"
        shutil.copytree(self.demo, wild)
        build = next(build for build in lines(wild, "Build") if "references" in build)
        path = wild / "data" / (build["geometry"][0]["inputs"][0]["data"] + ".npy")
        before, after = (number.to_bytes(8, "little") for number in (int(build["references"][0]["reference"], 16), 0x5000))
        path.write_bytes(path.read_bytes().replace(before, after, 1))
        finding = "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-12281"
        result = scene(LAVAPIPE, "replay", wild, "--layer")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn(f"finding: {finding}", result.stdout)
        small = self.folder / "small_wild"
        result = scene(LAVAPIPE, "minimize", wild, small, "--finding", finding)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([build.get("references", []) for build in lines(small, "Build")], [[]])
        self.assertEqual(len(lines(small, "Structure")), 1)

    def test_capture_of_a_replay(self):
        """A replay builds in the same places from the same data: captured again, only the instances differ."""
        again = self.folder / "again"
        result = scene(LAVAPIPE, "replay", self.demo, "--layer", capture=again)
        self.assertIn("findings: 0", result.stdout)
        instances = {data["data"] + ".npy" for build in lines(self.demo, "Build") for geometry in build["geometry"]
                     for data in geometry["inputs"] if data["role"] == "instances"}
        self.assertEqual(arrays(self.demo) - arrays(again), instances)
        self.expect_same_builds(again, self.demo)
        places = [{(line["Type"], line["name"], line["size"], line.get("usage"), line.get("offset")) for line in
                   lines(folder, "Buffer") + lines(folder, "Structure")} for folder in (self.demo, again)]
        self.assertEqual(*places)

    def expect_same_builds(self, one, other):
        one, other = (sorted(map(what_is_built, lines(folder, "Build")), key=str) for folder in (one, other))
        self.assertEqual(one, other)


class AssayRun(Case):
    def test_scene(self):
        page = self.folder / "scene.html"
        result = assay_run("--scene", page)
        self.assertEqual(result.returncode, 99, result.stderr)  # the demo's findings
        self.assertIn("assay-scene: accuracy in time", result.stderr)
        text = page.read_text("utf-8")
        self.assertIn("llvmpipe", text)
        self.assertLess(len(text), 5 << 20)


class Device(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.capture = cls.folder / "capture"
        result = assay_run("--capture", cls.capture)
        assert result.returncode == 99, result.stderr

    def report(self, *options, manifest=LAVAPIPE):
        file, log = self.folder / "report.json", self.folder / "log.txt"
        log.touch()
        result = scene(manifest, "report", self.capture, "--json", file, "--rays", 500, *options, hazards="true",
                       layers="VK_LAYER_ASSAY_validation", debug_action="log", log_filename=log)
        self.assertEqual((result.returncode, log.read_text("utf-8")), (0, ""), result.stderr)
        return json.loads(file.read_text("utf-8"))

    def test_sizes_and_times(self):
        """Sizes are those that the demo has asked the driver for; times are near those of a replay."""
        device = self.report()["device"]
        sizes = {line["name"]: line["size"] for line in lines(self.capture, "Structure") if "name" in line}
        rows = {row["flags"]: row for row in device["flags"]}
        self.assertEqual(rows["PREFER_FAST_TRACE"]["bytes"], sum(sizes[name] for name in (
            "mesh BLAS", "twisted BLAS", "box BLAS", "TLAS")))
        compacted = rows["PREFER_FAST_TRACE | ALLOW_COMPACTION"]
        self.assertLessEqual(compacted["compacted bytes"], compacted["bytes"])
        replay = scene(LAVAPIPE, "replay", self.capture, "--time", "--repeat", 3).stdout.splitlines()
        times = sum(float(line.split()[3]) for line in replay if line.endswith(("mesh BLAS", "twisted BLAS"))) / 1000
        self.assertGreater(rows["PREFER_FAST_TRACE"]["ms build"], times / 30)
        self.assertLess(rows["PREFER_FAST_TRACE"]["ms build"], times * 30)

    def test_rays(self):
        report = self.report()
        rows = {row["set"]: row for row in report["device"]["rays"]}
        self.assertEqual(list(rows), [each["rays"] for each in report["accuracy"]["sets"]])
        self.assertEqual(rows["camera"]["wrong"], 0)
        self.assertGreater(rows["vertices"]["wrong"], 1000)
        for row in rows.values():
            self.assertLess(row["nearest"], 500000)
            self.assertGreater(row["ns a ray"], 0)

    def test_no_device(self):
        self.assertIn("No device has built the scene: the Vulkan loader found no driver",
                      self.report(manifest="/nonexistent")["device"]["missing"])
        self.assertIn("no device of that name has", self.report("--device", "x")["device"]["missing"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], sys.argv[6]], verbosity=2)
