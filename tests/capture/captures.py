# SPDX-License-Identifier: Apache-2.0
"""Reads captures and checks all that docs/capture.md says of them, without a library of the project's."""

import ast
import json
import pathlib
import struct

try:
    import jsonschema
except ImportError:
    jsonschema = None

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCHEMA = json.loads((ROOT / "json/capture.schema.json").read_text("utf-8"))
SIZES = {"f2": 2, "f4": 4, "f8": 8, "i1": 1, "i2": 2, "i4": 4, "u1": 1, "u2": 2, "u4": 4, "u8": 8}


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
            self.arrays[data["data"]] = read_array(self.folder / "data" / f"{data['data']}.npy")
        shape = self.arrays[data["data"]][1]
        rows = min(data["count"], 1) if data["stride"] == 0 else data["count"]
        assert 0 < shape[0] <= rows, data

    def check_files(self, was_killed):
        """Each file belongs to a line, unless the process was killed in between."""
        files = {path.stem for path in (self.folder / "data").glob("*.npy")}
        assert was_killed or files == set(self.arrays), self.folder
        names = {path.name for path in (self.folder / "data").iterdir() if path.suffix != ".npy"}
        assert names <= ({"part"} if was_killed else set()), names
