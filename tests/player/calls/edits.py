#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Translates the edits of programs of calls (docs/contributing.md says how they read) to C: for each file
of programs a file NAME.inc, which defines call_edits_NAME; and all_edits.inc, which lists them."""

import argparse
import json
import pathlib
import re
import subprocess

WORD = re.compile(r"[A-Za-z_]\w*")
TEXT = re.compile(r'"(?:[^"\\]|\\.)*"')
WRITE = re.compile(r"(float|uint\d+_t) (.+)@(.+)")
MEMBER = re.compile(r"[a-z]\w*(\.\w+|\[[^]]*\])*")
LOCAL = re.compile(r"[a-z]\w*(\.\w+)*")
TYPES = ("float", "uint8_t", "uint16_t", "uint32_t", "uint64_t")
# Calls in edits that take no scene.
PLAIN_CALLS = ("sizeof", "offsetof", "unreadable_page", "memcpy", "memset", "for",
               "if", "place_offset", "messages_clear", "fixture_find_family",
               "bytes_before_unreadable_page", "deserialize_info", "command_is_on_host",
               "command_is_of_micromaps", "command_is_of_nv")
# Where messages say that members of the scene are, and with Vk that they name the object there. {0} and so
# on: what stands in brackets.
PATHS = [(re.compile(pattern + r"(?!\w)(.*)"), path) for pattern, path in (
    (r"infos\[(\w+)\]", "pInfos[{0}]"),
    (r"geometries\[(\w+)\]\[(\d+)\]", "pInfos[{0}].pGeometries[{1}]"),
    (r"ranges\[(\w+)\]\[(\d+)\]", "ppBuildRangeInfos[{0}][{1}]"),
    (r"range_pointers\[(\w+)\]", "ppBuildRangeInfos[{0}]"),
    (r"indirect_addresses\[(\w+)\]", "pIndirectDeviceAddresses[{0}]"),
    (r"indirect_strides\[(\w+)\]", "pIndirectStrides[{0}]"),
    (r"nv\.info", "pInfo->"),
    (r"nv\.geometries\[(\d+)\]", "pInfo->pGeometries[{0}]"),
    (r"life\.(?:copy|to_memory)\.src(?!\.)", "pInfo->src Vk"),
    (r"life\.(?:copy|from_memory)\.dst(?!\.)", "pInfo->dst Vk"),
    (r"life\.(?:copy|to_memory|from_memory)", "pInfo->"),
    (r"life\.create_at\.addressRange", "pCreateInfo->addressRange"),
    (r"life\.create(?:_at|_micromap|_nv)?", "pCreateInfo->"),
    (r"life\.builds\[(\d+)\]\.dstMicromap", "pInfos[{0}].dstMicromap Vk"),
    (r"life\.builds\[(\d+)\]", "pInfos[{0}]"),
    (r"life\.usages\[\d+\](?:\.\w+)?", "pUsageCounts"),
    (r"life\.objects\[(\w+)\]", "pAccelerationStructures[{0}] Vk"),
    (r"life\.query_type", "queryType"),
    (r"life\.pool", "queryPool"),
    (r"life\.first_query", "firstQuery"),
    (r"life\.stride", "stride"),
    (r"life\.data_size", "dataSize"),
    (r"life\.data_argument", "pData"),
    (r"life\.(?:address|capture)_info", "pInfo->"),
    (r"life\.bindings\[(\d+)\]\.memory", "pBindInfos[{0}].memory Vk"),
    (r"life\.bindings\[(\d+)\]", "pBindInfos[{0}]"),
    (r"life\.build_type", "buildType"),
    (r"life\.counts_argument", "pMaxPrimitiveCounts"),
    (r"life\.cluster_triangles", ".pTriangleClusters->"),
    (r"micromaps\.data", "pInfos[2].pGeometries[0].pNext"
     "<VkAccelerationStructureGeometryMicromapDataKHR>"),
    (r"micromaps\.usages\[\d+\](?:\.\w+)?", "pInfos[2].pGeometries[0].pNext"
     "<VkAccelerationStructureGeometryMicromapDataKHR>.pUsageCounts"),
    (r"micromaps\.usages_ext\[\d+\](?:\.\w+)?", "pInfos[0].pGeometries[0].geometry.triangles.pNext"
     "<VkAccelerationStructureTrianglesOpacityMicromapEXT>.pUsageCounts"),
    (r"micromaps\.opacity", "pInfos[0].pGeometries[0].geometry.triangles.pNext"
     "<VkAccelerationStructureTrianglesOpacityMicromapKHR>"),
    (r"micromaps\.opacity_ext", "pInfos[0].pGeometries[0].geometry.triangles.pNext"
     "<VkAccelerationStructureTrianglesOpacityMicromapEXT>"),
    (r"micromaps\.displacement", "pInfos[0].pGeometries[0].geometry.triangles.pNext"
     "<VkAccelerationStructureTrianglesDisplacementMicromapNV>"),
    (r"motion", "pInfos[0].pGeometries[0].geometry.triangles.pNext"
     "<VkAccelerationStructureGeometryMotionTrianglesDataNV>"),
    (r"spheres", "pInfos[6].pGeometries[0].pNext<VkAccelerationStructureGeometrySpheresDataNV>"),
    (r"swept_spheres", "pInfos[6].pGeometries[0].pNext"
     "<VkAccelerationStructureGeometryLinearSweptSpheresDataNV>"),
    (r"dense", "pInfos[6].pGeometries[0].pNext"
     "<VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX>"),
)]
BUILDS = ("INDEXED", "UNINDEXED", "AABBS", "TLAS", "UPDATE", "REFIT", "SPHERES")


def split(text, separator):
    """The parts of a text between separators outside of brackets and quotation marks."""
    parts, depth, start, at = [], 0, 0, 0
    while at < len(text):
        quoted = TEXT.match(text, at)
        if quoted:
            at = quoted.end()
            continue
        depth += (text[at] in "([{") - (text[at] in ")]}")
        if depth == 0 and text.startswith(separator, at):
            parts.append(text[start:at].strip())
            start = at + len(separator)
        at += 1
    return [part for part in parts + [text[start:].strip()] if part]


def closing(text, at):
    """The index of the bracket that closes the one at `at`."""
    depth = 0
    for index in range(at, len(text)):
        depth += (text[index] in "([{") - (text[index] in ")]}")
        if depth == 0:
            return index
    raise ValueError(f"no closing bracket: {text}")


def path_of(member):
    """The C string of what messages call a member of the scene, or NULL."""
    for pattern, path in PATHS:
        if found := pattern.fullmatch(member):
            *indices, rest = found.groups()
            indices = [str(BUILDS.index(index)) if index in BUILDS else index for index in indices]
            if not all(index.isdigit() for index in indices):
                continue
            path = path.format(*indices) + rest.replace(".deviceAddress", ".hostAddress")
            return '"' + path.replace("->.", "->") + '"'
    return "NULL"


def edited(edit):
    """The members that an edit is about."""
    if edit.startswith("{"):
        return [member for part in split(edit[1:-1], ",") for member in edited(part)]
    if edit.startswith(("for (", "if (")):
        return edited(edit[closing(edit, edit.index("(")) + 1:].strip())
    return [re.match(r"(?:destroy\()?(.*?)(?: \+= | = |\)$|$)", edit)[1]]


class File:
    """The edits of a file of programs, and the C functions that they become."""

    def __init__(self, name, members):
        self.name, self.members = name, members
        self.edits = {}  # text -> row of the table

    def expression(self, text):
        """C for an expression of edits: calls take the scene, and its members are its own."""
        def replace(found):
            word, follows = found[1], found[2]
            if word is None:
                return found[0]
            if word in self.members:
                return "scene->" + found[0]
            if follows and not word.isupper() and word not in PLAIN_CALLS:
                return f"{word}({'scene' if follows == '()' else 'scene, '}" + \
                    (")" if follows == "()" else "")
            return found[0]
        return re.sub(TEXT.pattern + r"|(?<![\w.>])([A-Za-z_]\w*)(\(\)|\()?", replace, text)

    def edit(self, text):
        """C for one edit."""
        if text.startswith("{"):
            return "{ " + " ".join(map(self.edit, split(text[1:-1], ","))) + " }"
        if text.startswith("let "):
            return f"__auto_type {self.expression(text[4:])};"
        if text.startswith(("for (", "if (")):
            end = closing(text, text.index("(")) + 1
            return f"{self.expression(text[:end])} {self.edit(text[end:].strip())}"
        if text.startswith("destroy("):
            return f"DESTROY({self.expression(text[8:-1])});"
        if text[0] != "(" and WORD.match(text)[0] not in (*self.members, *TYPES):
            return self.expression(text) + ";"
        parts = split(text, " += ")
        if len(parts) == 2:
            return f"ADD({self.expression(parts[0])}, {self.expression(parts[1])});"
        parts = split(text, " = ")
        if len(parts) == 1: # such as |=
            return self.expression(text) + ";"
        member, value = parts
        if write := WRITE.fullmatch(member):
            return f"WRITE({self.expression(write[2])}, {write[3]}, {write[1]}, " \
                   f"{self.expression(value)});"
        if LOCAL.fullmatch(value) and WORD.match(value)[0] not in self.members:
            return f"{self.expression(member)} = {value};"
        kind = "COPY" if MEMBER.fullmatch(value) and WORD.match(value)[0] in self.members else "SET"
        return f"{kind}({self.expression(member)}, {self.expression(value)});"

    def add(self, line):
        """Adds a line, which begins with `edit` or `configure`."""
        if line in self.edits:
            return
        kind, text = line.split(" ", 1)
        parts = split(text, ",")
        name = f"{self.name}_edit_{len(self.edits)}"
        if kind == "configure":
            body = "".join(f"    {part[:-1]}config);\n" if part.endswith("()") else f"    config->{part};\n"
                           for part in parts)
            self.edits[line] = (f"static void {name}(struct null_driver_config *config)\n{{\n{body}}}\n",
                                f"{{{json.dumps(text)}, NULL, {name}, NULL}}")
            return
        body = "".join(f"    {self.edit(part)}\n" for part in parts)
        body = body if "scene" in body else f"    (void)scene;\n{body}"
        paths = [path_of(member) for part in parts for member in edited(part)]
        path = next((path for path in paths if path != "NULL"), "NULL")
        self.edits[line] = (f"static void {name}(struct scene *scene)\n{{\n{body}}}\n",
                            f"{{{json.dumps(text)}, {name}, NULL, {path}}}")

    def text(self):
        functions = "".join(function for function, _ in self.edits.values())
        rows = "".join(f"    {row},\n" for _, row in self.edits.values())
        name = self.name
        return (f"{functions}static const struct call_edit rows_of_{name}[] = {{\n{rows}}};\n"
                f"const struct call_edits call_edits_{name} = {{\"calls/{name}\", rows_of_{name}, "
                f"sizeof(rows_of_{name}) / sizeof(rows_of_{name}[0])}};\n")


def write(path, text):
    """Writes a file, unless it has this text: then nothing is compiled again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", type=pathlib.Path, required=True, help="the header of struct scene")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the folder to write to")
    parser.add_argument("list_edits", nargs="+", help="the command that prints the edits")
    arguments = parser.parse_args()
    body = re.search(r"\nstruct scene \{(.*?)\n\};", arguments.scene.read_text("utf-8"), re.S)[1]
    members = set(re.findall(r"(\w+)(?:\[\w+\])*(?=[;,])", re.sub(r"/\*.*?\*/", "", body)))
    files = {}
    printed = subprocess.run(arguments.list_edits, stdout=subprocess.PIPE, text=True, check=True).stdout
    for line in printed.splitlines():
        group, edit = line.split("\t")
        name = group.removeprefix("calls/")
        files.setdefault(name, File(name, members)).add(edit)
    for name, file in files.items():
        write(arguments.out / f"{name}.inc", file.text())
    write(arguments.out / "all_edits.inc", "".join(f"EDITS({name})\n" for name in files))


if __name__ == "__main__":
    main()
