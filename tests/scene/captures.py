# SPDX-License-Identifier: Apache-2.0
"""Captures for the tests, written without the layer and read without assay-scene: docs/capture.md."""

import hashlib
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

ASSAY_SCENE = sys.argv[1]
INSTANCE = ("[('transform', '<f4', (3, 4)), ('customIndexAndMask', '<u4'), "
            "('offsetAndFlags', '<u4'), ('reference', '<u8')]")
IDENTITY = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
NAN = float("nan")


def npy(descr, shape, data):
    """The bytes of a file as numpy.save() writes it."""
    descr = descr if descr.startswith("[") else f"'{descr}'"
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * (-(len(header) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data


class Capture:
    """A folder that becomes a capture line by line."""

    def __init__(self, folder):
        self.folder = folder
        self.lines = []
        self.findings = []
        self.structures = set()
        self.number = 0
        (folder / "data").mkdir(parents=True)
        self.add("Capture", version=1, pid=7, time="2026-11-22T18:00:00.000001Z", LayerVersion="0.2.0",
                 Layer="VK_LAYER_ASSAY_validation", Application={"Name": "app", "Executable": "/bin/app"})
        self.add("Device", device="0xde", DeviceName="a device", Driver="a driver", DriverInfo="1.2",
                 limits={"scratch_alignment": 64})
        self.add("Memory", memory=1, size=1 << 20)
        self.add("Buffer", buffer=1, name="all", memory=1, memory_offset=0, size=1 << 20, usage="0x20")

    def add(self, kind, **members):
        if kind == "Structure":
            self.structures.add(members["structure"])
        self.lines.append({"Type": kind, **members})

    def command(self, kind, **members):
        self.number += 1
        self.add(kind, n=self.number, device="0xde", queue="0x9", submission=self.number,
                 command_buffer="0xcb", build=0, **members)

    def structure(self, number, kind="bottom level", name=None, size=256):
        """A build adds one without a name, unless it is there."""
        self.add("Structure", structure=number, handle=hex(0x1000 + number), type=kind, buffer=1, offset=0,
                 size=size, **({"name": name} if name else {}))

    def data(self, descr, shape, data):
        """Writes an array and returns its hash."""
        content = npy(descr, shape, data)
        name = hashlib.md5(content).hexdigest()
        (self.folder / "data" / f"{name}.npy").write_bytes(content)
        return name

    def rows(self, role, descr, code, rows, **members):
        """An input of rows of numbers."""
        width = len(rows[0])
        shape = {12: "(1, 3, 4)", 1: f"({len(rows)},)"}.get(width, f"({len(rows)}, {width})")
        size = struct.calcsize(code) * width
        data = b"".join(struct.pack(f"<{width}{code}", *row) for row in rows)
        return {"role": role, "address": "0x10000", "buffer": 1, "offset": 0, "first": 0, "count": len(rows),
                "stride": size, "size": size, "data": self.data(descr, shape, data), **members}

    def triangles(self, vertices, indices=None, matrix=None, descr="<f4", code="f",
                  vertex_format="VK_FORMAT_R32G32B32_SFLOAT", vertices_more=None, **members):
        inputs = [self.rows("vertices", descr, code, vertices, **(vertices_more or {}))]
        if indices:
            inputs.append(self.rows("indices", "<u2", "H", [(index,) for index in indices]))
        if matrix:
            inputs.append(self.rows("transform", "<f4", "f", [matrix]))
        return {"type": "triangles", "flags": "0x1", "primitiveCount": len(indices or vertices) // 3,
                "vertexFormat": vertex_format, "vertexStride": inputs[0]["stride"],
                "maxVertex": len(vertices) - 1, "inputs": inputs,
                "indexType": "VK_INDEX_TYPE_UINT16" if indices else "VK_INDEX_TYPE_NONE_KHR", **members}

    def boxes(self, boxes, **members):
        return {"type": "aabbs", "flags": "0x0", "primitiveCount": len(boxes), "stride": 24,
                "inputs": [self.rows("aabbs", "<f4", "f", boxes)], **members}

    def instances(self, instances, **members):
        """Each instance is (matrix, reference, custom index, mask, offset, flags), from the left."""
        data = b""
        for instance in instances:
            matrix, reference, custom, mask, offset, flags = instance + (0, 255, 0, 0)[len(instance) - 2:]
            data += struct.pack("<12fIIQ", *matrix, custom | mask << 24, offset | flags << 24, reference)
        name = self.data(INSTANCE, f"({len(instances)},)", data)
        return {"type": "instances", "flags": "0x0", "primitiveCount": len(instances), "inputs": [
            {"role": "instances", "address": "0x20000", "buffer": 1, "offset": 0, "count": len(instances),
             "stride": 64, "size": 64, "data": name}], **members}

    def build(self, structure, *geometry, kind="bottom level", mode="build", flags=0, **members):
        if structure not in self.structures:
            self.structure(structure, kind)
        self.command("Build", dst_id=structure, dst=hex(0x1000 + structure), type=kind, mode=mode,
                     flags=hex(flags), geometry=list(geometry), command="vkCmdBuildAccelerationStructuresKHR",
                     **members)
        return self.number

    def build_top(self, structure, instances, **members):
        """References are the ids of structures, unless `references` says more."""
        members.setdefault("references", [
            {"reference": hex(reference), **({"structure": reference} if reference in self.structures else {})}
            for reference in sorted({instance[1] for instance in instances} - {0})])
        return self.build(structure, self.instances(instances), kind="top level", **members)

    def finding(self, build, location, message, vuid="VUID-a-b"):
        self.findings.append({"Type": "Finding", "Severity": "Error", "VUID": vuid, "MainMessage": message,
                              "Location": location, "device": "0xde", "queue": "0x9", "submission": build,
                              "build": 0, "Objects": [
                                  {"type": "VkCommandBuffer", "handle": "0xcb"}]})

    def write(self):
        for name, lines in (("builds", self.lines), ("findings", self.findings)):
            text = "".join(line if isinstance(line, str) else json.dumps(line) + "\n" for line in lines)
            (self.folder / f"{name}.jsonl").write_text(text, encoding="utf-8")
        return self.folder


class Case(unittest.TestCase):
    """A test with a place of its own for files, and one for a capture in it."""

    def setUp(self):
        place = tempfile.TemporaryDirectory(prefix="assay-test-")
        self.addCleanup(place.cleanup)
        self.place = pathlib.Path(place.name)
        self.folder = self.place / "capture"

    def begin_again(self):
        """For the next of several captures."""
        self.doCleanups()
        self.setUp()


def run(*words):
    """Returns status, standard output and standard error."""
    process = subprocess.run([ASSAY_SCENE, *map(str, words)], capture_output=True, check=False)
    return process.returncode, process.stdout.decode(), process.stderr.decode()


def scene(folder):
    """A capture with all that tests look for: two meshes, boxes, an update, copies and a motionless top."""
    capture = Capture(folder)
    capture.structure(1, name="quad")
    capture.structure(2, name="boxes")
    capture.structure(3, name="compacted quad")
    capture.structure(4, "top level", name="world")
    capture.structure(5, name="unused \x1b[31m é")
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    quad = [0, 1, 2, 0, 2, 3]
    capture.build(1, capture.triangles(corners, quad, matrix=(2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 0)),
                  capture.triangles([(0, 0, 1), (1, 0, 1), (NAN, 0, 0)]), flags=3, frame=1)
    capture.build(2, capture.boxes([(0, 0, 0, 1, 2, 3), (NAN, 0, 0, 0, 0, 0)]), frame=1)
    capture.build(5, capture.triangles(corners, quad), flags=3, frame=1, region="load::meshes")
    capture.command("Query", query="compacted size", src_id=1, frame=1)
    capture.command("CompactedSize", dst_id=1, compacted_size=128)
    capture.command("Copy", mode="compact", src_id=1, dst_id=3, frame=2)
    capture.build_top(4, [(IDENTITY, 3), ((1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0), 2, 7, 1, 9, 1),
                          ((0, -1, 0, 0, 2, 0, 0, 0, 0, 0, -3, 0), 1), (IDENTITY, 0), (IDENTITY, 99)], frame=2)
    return capture
