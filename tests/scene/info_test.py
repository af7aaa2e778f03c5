# SPDX-License-Identifier: Apache-2.0
"""assay-scene info, and what assay-scene says of arguments and damaged captures.

usage: info_test.py ASSAY_SCENE"""

import json
import pathlib
import re
import subprocess
import sys
import unittest

from captures import IDENTITY, Capture, Case, npy, run, scene

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


class InfoCase(Case):
    def info(self, capture, *options):
        capture.write()
        status, out, err = run("info", self.folder, *options)
        self.assertEqual((status, err), (0, ""))
        return out

    def figures(self, capture):
        return json.loads(self.info(capture, "--json"))

    def expect_error(self, says):
        """Both commands name the file and the line, and end with 2."""
        for words in (["info", self.folder], ["export", self.folder, self.folder / "scene.glb"]):
            status, out, err = run(*words)
            self.assertEqual((status, out), (2, ""), says)
            self.assertRegex(err, r"\Aassay-scene: [^\n]+\n\Z")
            self.assertIn(says, err)


class Info(InfoCase):
    def test_figures(self):
        info = self.figures(scene(self.folder))
        self.assertEqual(info["summary"]["commands"], 7)
        self.assertEqual(info["summary"]["application"], "app")
        self.assertEqual(info["devices"], [{"device": "a device", "driver": "a driver", "version": "1.2"}])
        rows = {row["structure"]: row for row in info["structures"]}
        self.assertEqual(rows[1], {
            "structure": 1, "name": "quad", "type": "bottom level", "flags": "0x3", "geometries": 2,
            "primitives": 3, "bytes": 256, "builds": 1, "updates": 0, "compactions": 1, "clones": 0,
            "destroyed": 0, "instances": 1})
        self.assertEqual((rows[3]["builds"], rows[3]["primitives"], rows[3]["instances"]), (0, 3, 1))
        types = {row["type"]: row for row in info["types of structures"]}
        self.assertEqual(types["bottom level"]["structures"], 4)
        self.assertEqual(types["bottom level"]["builds"], 3)
        self.assertEqual(types["top level"]["primitives"], 5)

    def test_effects(self):
        info = self.figures(scene(self.folder))
        self.assertEqual({row["effect"]: row["count"] for row in info["effects"]}, {
            "compactions": 1, "builds of several geometries": 1, "opaque geometries": 3,
            "geometries with a transform": 1, "geometries of AABBs": 1, "instances without culling of faces": 1,
            "instances with another mask than 0xff": 1, "instances with a mirrored transform": 1,
            "instances without a structure": 1})
        self.assertEqual({row["unused"]: row["structures"] for row in info["enabled and not used"]}, {
            "ALLOW_UPDATE, never updated": [1, 5], "ALLOW_COMPACTION, never compacted": [5],
            "built, never referred to": [5]})

    def test_an_update_of_a_copy_is_one_of_what_was_built(self):
        capture = Capture(self.folder)
        capture.structure(1)
        capture.structure(2)
        mesh = capture.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
        capture.build(1, mesh, flags=1)
        capture.command("Copy", mode="clone", src_id=1, dst_id=2)
        capture.build(2, mesh, mode="update", src_id=2, flags=1)
        capture.command("Destroyed", dst_id=1)
        info = self.figures(capture)
        self.assertEqual(info["enabled and not used"], [])
        self.assertEqual([row["destroyed"] for row in info["structures"]], [1, 0])
        self.assertEqual({row["effect"]: row["count"] for row in info["effects"]},
                         {"clones": 1, "updates": 1, "opaque geometries": 2})

    def test_rare_effects(self):
        capture = Capture(self.folder)
        motion = capture.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)], flags="0x2")
        capture.build(1, motion, flags=0x20)
        motion = dict(motion, inputs=[*motion["inputs"], {"role": "opacity indices", "missing": "why"},
                                      {"role": "displacement indices"}])
        capture.build(1, motion, {"type": "spheres"}, {"type": "linear swept spheres"}, {"type": "dense triangles"},
                      {"type": "what comes"}, flags=0x20)
        capture.lines[-1].pop("queue")
        capture.lines[-1]["command"] = "vkCmdBuildAccelerationStructuresIndirectKHR"
        capture.build_top(2, [(IDENTITY, 1, 0, 255, 0, flag) for flag in (2, 4, 8, 16, 32)])
        capture.lines[-1]["geometry"][0]["arrayOfPointers"] = 1
        info = self.figures(capture)
        for effect in ("builds by the host", "indirect builds", "geometries of spheres",
                       "geometries of linear swept spheres", "geometries of dense triangles",
                       "geometries with opacity micromaps", "geometries with displacement micromaps",
                       "arrays of pointers to instances", "instances with flipped faces",
                       "instances that are forced to be opaque", "instances that are forced not to be opaque",
                       "instances with micromaps forced to two states", "instances without their micromaps"):
            self.assertIn({"effect": effect, "count": 1}, info["effects"])
        self.assertIn({"unused": "MOTION, no motion data", "count": 1, "structures": [1]},
                      info["enabled and not used"])

    def test_text(self):
        capture = scene(self.folder)
        capture.add("End", why="the device was destroyed")
        text = self.info(capture)
        self.assertIn("compacted quad", text)
        self.assertIn(r"unused \x1b[31m é", text)
        self.assertIn("the device was destroyed", text)
        self.assertRegex(text, r"(?m)^  ALLOW_UPDATE, never updated +2$")

    def test_long_tables_end(self):
        capture = Capture(self.folder)
        for number in range(1, 61):
            capture.structure(number, name=f"number {number}")
        text = self.info(capture)
        self.assertIn("... and 20 more: --all lists them", text)
        self.assertNotIn("number 41", text)
        self.assertIn("number 60", self.info(capture, "--all"))

    def test_what_is_not_known_is_skipped(self):
        capture = scene(self.folder)
        before = self.figures(capture)
        capture.lines[1]["Novelty"] = {"a": [1, 2]}
        capture.add("Novelty", n=-1)
        self.assertEqual(self.figures(capture), before)

    def test_a_cut_last_line(self):
        scene(self.folder).write()
        file = self.folder / "builds.jsonl"
        text = file.read_text(encoding="utf-8")
        file.write_text(text + text.splitlines()[1][:20], encoding="utf-8")
        status, out, err = run("info", self.folder)
        self.assertEqual((status, err), (
            0, f"assay-scene: {file}:{len(text.splitlines()) + 1}: the last line was cut, and is left out\n"))
        self.assertIn("compacted quad", out)
        file.write_text(text[:30], encoding="utf-8")
        self.expect_error("builds.jsonl:1: has no whole line")


def set_at(*path):
    """Returns what changes a value in a capture: an index of a line from its end, keys, and the value."""
    def change(capture):
        place = capture.lines[path[0]]
        for key in path[1:-2]:
            place = place[key]
        place[path[-2]] = path[-1]
    return change


def write_data(content, which=0):
    """Replaces the array of an input of the build that is the last line."""
    def change(capture):
        name = capture.lines[-1]["geometry"][0]["inputs"][which]["data"]
        (capture.folder / "data" / f"{name}.npy").write_bytes(content)
    return change


def remove_data(capture):
    name = capture.lines[-1]["geometry"][0]["inputs"][0]["data"]
    (capture.folder / "data" / f"{name}.npy").unlink()


def cut_in_the_middle(capture):
    capture.lines[3] = json.dumps(capture.lines[3])[:30] + "\n"


INPUT = (-1, "geometry", 0, "inputs", 0)
VERTICES = bytes(48)
DAMAGES = {
    "a cut line": (cut_in_the_middle, "builds.jsonl:4: is not JSON: "),
    "no object": (lambda capture: capture.lines.append("[1]\n"), "builds.jsonl:7: is no object"),
    "no type": (set_at(2, "Type", 5), "builds.jsonl:3: is no object with a Type"),
    "deep nesting": (lambda capture: capture.lines.append("[" * 5000 + "]" * 5000 + "\n"),
                     "builds.jsonl:7: is not JSON: maximum parsing depth reached"),
    "a key twice": (lambda capture: capture.lines.append('{"Type":"End","Type":"End"}\n'),
                    "builds.jsonl:7: is not JSON: duplicate object key"),
    "no header": (set_at(0, "Type", "End"), "builds.jsonl:1: the first line has another"),
    "another version": (set_at(0, "version", 2), "builds.jsonl:1: is of a version"),
    "a text for a number": (set_at(2, "size", "1"), "builds.jsonl:3: size is not a number"),
    "a fraction": (set_at(2, "size", 1.5), "builds.jsonl:3: size is not a number"),
    "a negative number": (set_at(2, "size", -1), "builds.jsonl:3: size is not a number"),
    "a number of 65 bits": (set_at(2, "size", 1 << 64), "builds.jsonl:3: is not JSON: too big integer"),
    "a number for a text": (set_at(1, "device", 5), "builds.jsonl:2: device is not a text such as"),
    "no hexadecimal digits": (set_at(1, "device", "0xg"), "builds.jsonl:2: device is not a text such as"),
    "a list for a name": (set_at(3, "name", []), "builds.jsonl:4: name is not a text"),
    "a lacking key": (lambda capture: capture.lines[2].pop("memory"), "builds.jsonl:3: lacks memory"),
    "id 0": (set_at(2, "memory", 0), "builds.jsonl:3: introduces id 0"),
    "an id twice": (lambda capture: capture.structure(1), "builds.jsonl:7: introduces id 1 again"),
    "an unknown memory": (set_at(3, "memory", 9), "builds.jsonl:4: memory is not the id of a memory"),
    "an unknown buffer": (set_at(4, "buffer", 9), "builds.jsonl:5: buffer is not the id of a buffer"),
    "an unknown structure": (set_at(-1, "dst_id", 9), "builds.jsonl:6: dst_id is not the id of a structure"),
    "n again": (lambda capture: capture.lines.append(dict(capture.lines[-1])), "builds.jsonl:7: n is 1 behind 1"),
    "flags of 33 bits": (set_at(-1, "flags", "0x100000000"), "of up to 32 bits"),
    "a large count": (set_at(-1, "geometry", 0, "primitiveCount", 1 << 32), "a number from 0 to 4294967295"),
    "geometry is no array": (set_at(-1, "geometry", {}), "builds.jsonl:6: geometry is not an array"),
    "a geometry is no object": (set_at(-1, "geometry", [5]), "has something else where an object"),
    "inputs are no array": (set_at(-1, "geometry", 0, "inputs", 5), "inputs is not an array"),
    "an input is no object": (set_at(-1, "geometry", 0, "inputs", ["vertices"]), "an object with role"),
    "scratch is no object": (set_at(-1, "scratch", 5), "scratch.address is of no object"),
    "a reference is no object": (set_at(-1, "references", [None]), "an object with reference"),
    "dead is no truth": (set_at(-1, "references", [{"reference": "0x1", "is_dead": "no"}]), "is not true or false"),
    "no hash": (set_at(*INPUT, "data", "../../../../etc/passwd"), "data is not 32 hexadecimal digits"),
    "a missing file": (remove_data, ".npy: cannot be read: No such file"),
    "fewer elements than rows": (set_at(*INPUT, "count", 2), "has 3 rows, but count is 2"),
    "an empty array": (write_data(b""), ".npy: is no array of NumPy"),
    "another magic": (write_data(b"\x93NUMPX" + bytes(100)), ".npy: is no array of NumPy"),
    "format 2.0": (write_data(b"\x93NUMPY\x02\x00" + bytes(100)), ".npy: is no array of NumPy"),
    "a cut header": (write_data(npy("<f4", "(4, 3)", b"")[:40]), ".npy: ends in its header"),
    "short data": (write_data(npy("<f4", "(4, 3)", bytes(47))), "has 47 bytes of data, but its shape needs 48"),
    "long data": (write_data(npy("<f4", "(4, 3)", bytes(49))), "has 49 bytes of data, but its shape needs 48"),
    "another type": (write_data(npy(">f4", "(4, 3)", VERTICES)), "has a type that no capture has"),
    "objects": (write_data(npy("|O", "(4, 3)", VERTICES)), "has a type that no capture has"),
    "four dimensions": (write_data(npy("<f4", "(1, 1, 4, 3)", VERTICES)), "has no shape of a capture"),
    "a negative shape": (write_data(npy("<f4", "(-4, 3)", VERTICES)), "has no shape of a capture"),
    "a large shape": (write_data(npy("<f4", "(18446744073709551615, 3)", VERTICES)), "has no shape of a capture"),
    "a larger shape": (write_data(npy("<f4", "(99999999999999999999999, 3)", VERTICES)), "has no shape"),
    "rows of nothing": (write_data(npy("<f4", "(4, 0)", b"")), "has no shape of a capture"),
    "Fortran's order": (write_data(npy("<f4", "(4, 3)", VERTICES).replace(b"False", b"True ")), "is not in C order"),
    "no shape": (write_data(npy("<f4", "(4, 3)", VERTICES).replace(b"shape", b"sheep")), "has no shape"),
    "instances as vertices": (set_at(*INPUT, "role", "instances"), ".npy has no rows of instances"),
    "vertices as boxes": (set_at(*INPUT, "role", "aabbs"), ".npy has no rows of aabbs"),
    "vertices as indices": (set_at(*INPUT, "role", "indices"), ".npy has no rows of indices"),
    "vertices as transform": (set_at(*INPUT, "role", "transform"), ".npy has no rows of transform"),
}


class Damage(InfoCase):
    def test_damages(self):
        for name, (change, says) in DAMAGES.items():
            with self.subTest(name):
                self.begin_again()
                capture = Capture(self.folder)
                capture.build(1, capture.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))
                change(capture)
                capture.write()
                self.expect_error(says)

    def test_largest_numbers(self):
        capture = Capture(self.folder)
        capture.build(1, capture.triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))
        for path, value in (((-1, "flags"), "0xffffffff"), ((-1, "geometry", 0, "primitiveCount"), 0xffffffff)):
            set_at(*path, value)(capture)
        structures = self.figures(capture)["structures"]
        self.assertEqual((structures[0]["flags"], structures[0]["primitives"]), ("0xffffffff", 0xffffffff))

    def test_findings(self):
        for text, says in (("{\n", "findings.jsonl:1: is not JSON"), ("[5]\n", "findings.jsonl:1: is no object"),
                           ('{"Type":"Finding","VUID":"a"}\n', "findings.jsonl:1: has no texts"),
                           ('{"Type":"Finding","queue":1}\n', "findings.jsonl:1: queue is not")):
            folder = self.folder / str(len(text))
            Capture(folder).write()
            (folder / "findings.jsonl").write_text(text, encoding="utf-8")
            self.assertIn(says, run("info", folder)[2])

    def test_no_capture(self):
        self.expect_error("builds.jsonl: cannot be read: No such file or directory")
        (self.folder / "builds.jsonl").mkdir(parents=True)
        self.expect_error("builds.jsonl: cannot be read: Is a directory")


class Arguments(InfoCase):
    def test_wrong_arguments(self):
        for words, says in (([], "name a command"), (["look"], "unknown command: look"),
                            (["info"], "name a capture"), (["info", "a", "b"], "one argument too many: b"),
                            (["info", "a", "--at", "b"], "unknown option: at"), (["info", "a", "--bt"], "unknown option: --bt"),
                            (["export", "a"], "name the file to write"),
                            (["export", "a", "b", "c"], "one argument too many: c"),
                            (["export", "a", "--json"], "unknown option: json"),
                            (["export", "a", "b", "--color", "\x1b"], r"not a value of an option: \x1b")):
            status, out, err = run(*words)
            self.assertEqual((status, out), (2, ""))
            self.assertTrue(err.startswith(f"assay-scene: {says}"), err)

    def test_help(self):
        status, out, _ = run("--help")
        self.assertEqual(status, 0)
        self.assertEqual(run("info", "--help")[:2], (0, out))
        self.assertEqual(run("--version")[0], 0)
        page = (ROOT / "docs/man/assay-scene.1").read_text(encoding="utf-8").replace("\\-", "-")
        script = ROOT / "scripts/assay_run/completion.bash"
        for option in ("--help", "--version"):
            self.assertIn(option, page)
        for command in ("info", "export", "view", "replay", "minimize", "report"):
            section = out.split(f"\n{command}: ")[1].split("\n\n")[0]
            options = sorted(set(re.findall(r"--[a-z-]+", " ".join(re.findall(r"^  (--[a-z-]+(?:, --[a-z-]+)?)", section, re.M)))))
            words = subprocess.run(
                ["bash", "-c", f"source {script}; COMP_WORDS=(assay-scene {command} --); COMP_CWORD=2; "
                 "_assay_scene; printf '%s\\n' \"${COMPREPLY[@]}\""],
                capture_output=True, encoding="utf-8", check=True).stdout.split()
            self.assertEqual(sorted(words), options)
            for option in options:
                self.assertIn(option, page)
        for status in re.findall(r"^  (\d+) ", out, re.M):
            self.assertIn(f".B {status}", page)

    def test_a_full_disk(self):
        scene(self.folder).write()
        with open("/dev/full", "w", encoding="utf-8") as full:
            process = subprocess.run([sys.argv[1], "info", self.folder], stdout=full, stderr=subprocess.PIPE,
                                     check=False)
        self.assertEqual(process.returncode, 2)
        self.assertIn(b"assay-scene: standard output: No space left on device", process.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
