# SPDX-License-Identifier: Apache-2.0
"""Reads binary glTF 2.0 by itself: the triangles of a file, where its nodes place them."""

import json
import math
import struct

FORMATS = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def rotation_matrix(x, y, z, w):
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def matrix_of(translation=(0, 0, 0), rotation=(0, 0, 0, 1), scale=(1, 1, 1)):
    """Rows of 4."""
    return [[value * factor for value, factor in zip(row, scale)] + [translation[i]]
            for i, row in enumerate(rotation_matrix(*rotation))]


def product(left, right):
    full = [*right, [0, 0, 0, 1]]
    return [[sum(row[k] * full[k][j] for k in range(4)) for j in range(4)] for row in left]


def apply(matrix, point):
    return tuple(sum(row[i] * point[i] for i in range(3)) + row[3] for row in matrix)


class Gltf:
    def __init__(self, path):
        content = path.read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", content)
        assert (magic, version, length, kind) == (b"glTF", 2, len(content), b"JSON")
        assert length % 4 == 0 and size % 4 == 0
        self.root = json.loads(content[20:20 + size])
        self.binary = content[28 + size:]
        if "buffers" in self.root:
            assert struct.unpack_from("<I4s", content, 20 + size) == (len(self.binary), b"BIN\0")
            assert self.root["buffers"] == [{"byteLength": len(self.binary)}]

    def accessor(self, index):
        accessor = self.root["accessors"][index]
        view = self.root["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        width, code = WIDTHS[accessor["type"]], FORMATS[accessor["componentType"]]
        values = struct.unpack_from(f"<{width * accessor['count']}{code}", self.binary, view["byteOffset"])
        rows = [values[i:i + width] for i in range(0, len(values), width)]
        if "min" in accessor:
            assert accessor["min"] == [min(column) for column in zip(*rows)]
            assert accessor["max"] == [max(column) for column in zip(*rows)]
        assert all(map(math.isfinite, values))
        return rows

    def mesh_triangles(self, mesh):
        """(corners, primitive of the mesh) for each triangle."""
        for primitive in mesh["primitives"]:
            positions = self.accessor(primitive["attributes"]["POSITION"])
            indices = [row[0] for row in self.accessor(primitive["indices"])]
            for i in range(0, len(indices), 3):
                yield tuple(positions[index] for index in indices[i:i + 3]), primitive

    def placements(self, node, outer=None):
        """(matrix, mesh) for each mesh of a node and of its children."""
        own = matrix_of(*(node.get(key, value) for key, value in
                          (("translation", (0, 0, 0)), ("rotation", (0, 0, 0, 1)), ("scale", (1, 1, 1)))))
        own = product(outer, own) if outer else own
        shared = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes")
        if shared:
            for parts in zip(*(self.accessor(shared[key]) for key in ("TRANSLATION", "ROTATION", "SCALE"))):
                yield product(own, matrix_of(*parts)), self.root["meshes"][node["mesh"]]
        elif "mesh" in node:
            yield own, self.root["meshes"][node["mesh"]]
        for child in node.get("children", ()):
            yield from self.placements(self.root["nodes"][child], own)

    def nodes(self):
        return [self.root["nodes"][index] for index in self.root["scenes"][0].get("nodes", ())]

    def triangles(self):
        """The corners of all triangles, in the space of the scene."""
        return [tuple(apply(matrix, corner) for corner in corners)
                for node in self.nodes() for matrix, mesh in self.placements(node)
                for corners, _ in self.mesh_triangles(mesh)]

    def left_out(self):
        return self.root["scenes"][0]["extras"]["leftOut"]
