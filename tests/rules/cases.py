#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Translates cases (tests/rules/cases/*.cases; docs/contributing.md says how they read) to C: for each list
a file LIST.inc that defines cases_LIST."""

import argparse
import json
import pathlib
import re
import sys

WORD = re.compile(r"[A-Za-z_]\w*")
TEXT = re.compile(r'"(?:[^"\\]|\\.)*"')
WRITE = re.compile(r"(float|uint\d+_t) (.+)@(.+)")
MEMBER = re.compile(r"[a-z]\w*(\.\w+|\[[^]]*\])*")
LOCAL = re.compile(r"[a-z]\w*(\.\w+)*")
STEPS = ("prepare", "wrong", "fine", "right")
FLAGS = ("needs_null_driver", "needs_drivers_sizes", "spares_drivers", "may_fail_on_cpu",
         "keep_arrays", "forwards", "below_content", "is_wild", "has_pointers", "is_for_the_call",
         "is_for_contents")
TYPES = ("float", "uint8_t", "uint16_t", "uint32_t", "uint64_t")
# Calls in edits that take no scene.
PLAIN_CALLS = ("sizeof", "offsetof", "unreadable_page", "memcpy", "memset", "for",
               "if", "place_offset", "messages_clear", "fixture_find_family",
               "bytes_before_unreadable_page", "deserialize_info", "command_is_on_host",
               "command_is_of_micromaps", "command_is_of_nv")
# Where messages say that members of the scene are. {0} and so on: what stands in brackets.
PATHS = [(re.compile(pattern + r"(?!\w)(.*)"), path) for pattern, path in (
    (r"infos\[(\w+)\]", "pInfos[{0}]"),
    (r"geometries\[(\w+)\]\[(\d+)\]", "pInfos[{0}].pGeometries[{1}]"),
    (r"ranges\[(\w+)\]\[(\d+)\]", "ppBuildRangeInfos[{0}][{1}]"),
    (r"range_pointers\[(\w+)\]", "ppBuildRangeInfos[{0}]"),
    (r"indirect_addresses\[(\w+)\]", "pIndirectDeviceAddresses[{0}]"),
    (r"indirect_strides\[(\w+)\]", "pIndirectStrides[{0}]"),
    (r"nv\.info", "pInfo->"),
    (r"nv\.geometries\[(\d+)\]", "pInfo->pGeometries[{0}]"),
    (r"life\.(?:copy|to_memory|from_memory)", "pInfo->"),
    (r"life\.create_at\.addressRange", "pCreateInfo->addressRange"),
    (r"life\.create(?:_at|_micromap|_nv)?", "pCreateInfo->"),
    (r"life\.objects\[(\w+)\]", "pAccelerationStructures[{0}]"),
    (r"life\.query_type", "queryType"),
    (r"micromaps\.data", "pInfos[2].pGeometries[0].pNext"
     "<VkAccelerationStructureGeometryMicromapDataKHR>"),
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


class Defines(dict):
    """What `define` lines say: by a name, its parameters or None, and the text in its place."""

    def add(self, text):
        head = re.match(r"(\w+)(?:\(([\w, ]*)\))? (.*)", text)
        self[head[1]] = (None if head[2] is None else split(head[2], ","), head[3])

    def expand(self, text):
        at = 0
        while at < len(text):
            if quoted := TEXT.match(text, at):
                at = quoted.end()
                continue
            word = WORD.match(text, at)
            if not word:
                at += 1
                continue
            at = word.end()
            parameters, body = self.get(word[0], (None, None))
            if body is None or (parameters is not None and not text.startswith("(", at)):
                continue
            if parameters is not None:
                end = closing(text, at)
                for name, argument in zip(parameters, split(text[at + 1:end], ",")):
                    if re.search(r"^[^\"]* (?:[-+*/|&]|<<) ", argument):
                        argument = f"({argument})"
                    body = re.sub(rf"(?<!#)#{name}\b", lambda _, a=argument: f'"{a}"', body)
                    body = re.sub(rf"##{name}\b|(?<![.>\w]){name}\b", lambda _, a=argument: a, body)
                at = end + 1
            if "let " in body:
                body = "{" + body + "}"
            text = text[:word.start()] + body + text[at:]
            at = word.start()
        return text


def path_of(member):
    """The C string of what messages call a member of the scene, or None."""
    for pattern, path in PATHS:
        if found := pattern.fullmatch(member):
            *indices, rest = found.groups()
            indices = [BUILDS.index(index) if index in BUILDS else index for index in indices]
            path = path.format(*indices) + rest.replace(".deviceAddress", ".hostAddress")
            return '"' + path.replace("->.", "->") + '"'
    return None


def edited(edit):
    """The member that an edit is about."""
    member = re.match(r"(?:destroy\()?(.*?)(?: \+= | = |\)$|$)", edit)
    return member[1]


class List:
    """A list of cases, and the C functions that its edits become."""

    def __init__(self, name, members):
        self.name, self.members = name, members
        self.rows, self.setups, self.functions, self.configurations = [], {}, {}, []

    def configure(self, name, edits):
        """Adds a function for setups, which sets members of the null driver's configuration."""
        body = "".join(f"    config->{edit};\n" for edit in edits)
        self.configurations.append(
            f"static void {name}(struct null_driver_config *config)\n{{\n{body}}}\n")

    def setup(self, text):
        """A pointer to a setup, which every case with the same one shares."""
        return "&" + self.setups.setdefault(text, f"{self.name}_setup_{len(self.setups)}")

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

    def function(self, edits):
        """The name of the C function that makes edits."""
        body = "".join(f"    {self.edit(edit)}\n" for edit in edits)
        body = body if "scene" in body else f"    (void)scene;\n{body}"
        return self.functions.setdefault(body, f"{self.name}_edits_{len(self.functions)}")

    def write(self, path):
        lines = self.configurations + [f"static const struct setup {name} = {text};\n"
                                       for text, name in self.setups.items()]
        lines += [f"static void {name}(struct scene *scene)\n{{\n{body}}}\n"
                  for body, name in self.functions.items()]
        lines += [f"static const struct test_case {self.name}_rows[] = {{\n", *self.rows, "};\n",
                  f"CASE_LIST(cases_{self.name}, {self.name}_rows);\n"]
        text = "".join(lines)
        if not path.exists() or path.read_text(encoding="utf-8") != text:  # else nothing is compiled anew
            path.write_text(text, encoding="utf-8")


def alternatives(edits):
    """Edits without those of the form `not X`, and the edits with X in its place."""
    wrong, right = [], []
    for edit in edits:
        if not edit.startswith("not "):
            wrong.append(edit)
            right.append(edit)
            continue
        value, before = edit[4:], wrong[-1]
        sides = split(before, " = ") if " += " not in before else split(before, " += ")
        if len(sides) == 2:
            right[-1] = before[:len(before) - len(sides[1])] + value
        else:
            *others, _ = split(before[before.index("(") + 1:-1], ",")
            right[-1] = f"{before[:before.index('(')]}({', '.join([*others, value])})"
    return wrong, right if right != wrong else None


def read_items(text, defines):
    """The items of a case or a group, by their keywords."""
    items = {}
    for item in split(text, ";"):
        word, _, rest = item.partition(" ")
        if word in STEPS:
            also = rest.startswith("also ")
            items[word] = (also, split(rest[5 * also:], ","))
        elif word in FLAGS:
            items[word] = "true"
        elif word in ("says", "on", "setup", "right_setup", "refusal", "names", "count"):
            items[word] = defines.expand(rest)
        else:
            if word == "silent":
                items["silent"], item = "true", rest
            if item and not re.fullmatch(r"\w+(, *\w+)*", item):
                raise ValueError("this is neither a known item nor a list of rules; is a semicolon missing?",
                                 item)
            if item:
                items["rules"] = item
    return items


def inherit(items, group):
    """The items of a case with those of its group. What follows rules is of the rules."""
    whole = {key: value for key, value in group.items()
             if key not in items and (key != "names" or "rules" not in items)}
    for key, value in items.items():
        if isinstance(value, tuple) and value[0]:
            value = (False, group[key][1] + value[1])
        whole[key] = value
    return whole


def rule_list(field, count, text):
    names = ", ".join(f"RULE_{name}" for name in split(text, ","))
    return (f".{field} = (const enum rule[]){{{names}}}", f".{count} = {len(split(text, ','))}")


def row(cases, name, place, items, setups, defines):
    """The C row of a case, which stands at a place."""
    fields = [f'.name = "{name}"', f".place = {json.dumps(place)}"]
    steps = {key: value[1] for key, value in items.items() if isinstance(value, tuple)}
    if ("fine" in steps) and "silent" not in items or "wrong" in steps and "silent" in items:
        raise ValueError("silent cases have `fine`, and others `wrong`")
    steps["wrong"], right = alternatives(steps.pop("fine", steps.get("wrong", [])))
    if right:
        steps["right"] = right
    for key, edits in steps.items():
        steps[key] = [part for edit in edits for part in split(defines.expand(edit), ",")]
    for key in ("prepare", "wrong", "right"):
        if steps.get(key):
            fields.append(f".{key} = {cases.function(steps[key])}")
    says = items.get("says")
    if says is None:
        says = next(filter(None, map(path_of, map(edited, steps["wrong"]))), None)
    if says and says != "anything":
        fields.append(f".path = {says}")
    for key in ("setup", "right_setup"):
        if key in items:
            fields.append(f".{key} = {cases.setup(setups.get(items[key], items[key]))}")
    if "on" in items:
        fields.append(".commands = " + " | ".join(f"ON_{word.upper()}" if word.islower() else f"UINT64_C(1) << COMMAND_{word}"
                                                  for word in items["on"].split()))
    for key, count in (("rules", "rule_count"), ("names", "name_count")):
        if key in items:
            fields += rule_list(key, count, items[key])
    if "refusal" in items:
        fields.append(f".refusal = &{items['refusal']}")
    fields += [f".{key} = {items[key]}" for key in ("silent", "count", *FLAGS) if key in items]
    cases.rows.append(f"    {{{', '.join(fields)}}},\n")


def repeated(lines):
    """(number, line) of each line. Those between `each WORD...:` and `end` come once for each word,
    with the word in place of {}."""
    words, block = None, []
    for number, line in enumerate(lines, 1):
        if line.startswith("each "):
            words, block = line[5:].rstrip(":").split(), []
        elif words and line == "end":
            yield from ((at, text.replace("{}", word)) for word in words for at, text in block)
            words = None
        elif words:
            block.append((number, line))
        else:
            yield number, line


def logical_lines(path):
    """(number, text) of each line with the indented lines behind it."""
    number, text = 0, ""
    for index, line in repeated(path.read_text(encoding="utf-8").splitlines()):
        if line.startswith("#") or not line.strip():
            continue
        if line.startswith(" "):
            text += " " + line.strip()
            continue
        if text:
            yield number, text
        number, text = index, line
    if text:
        yield number, text


def read(path, members, common):
    """The lists of a file."""
    shared, shared_setups, lists, group = Defines(common), {}, [], {}
    defines, setups = shared, shared_setups
    for number, text in logical_lines(path):
        try:
            word, _, rest = text.partition(" ")
            if word == "define":
                defines.add(rest)
            elif word == "setup":
                name, _, fields = rest.partition(" ")
                setups[name] = f"{{{fields}}}"
            elif word == "configure":
                name, _, edits = rest.partition(" ")
                lists[-1].configure(name, split(defines.expand(edits), ","))
            elif word == "list":
                lists.append(List(rest, members))
                defines, setups, group = Defines(shared), dict(shared_setups), {}
            elif word == "group:":
                group = read_items(rest, defines)
            else:
                name, colon, rest = text.partition(":")
                if not colon:
                    raise ValueError("a colon is missing behind the name of the case")
                row(lists[-1], name, f"tests/rules/{path}:{number}: {text}", inherit(read_items(rest.strip(), defines), group),
                    setups, defines)
        except (KeyError, IndexError, ValueError, TypeError) as error:
            sys.exit(f"{path}:{number}: {error!r} in: {text}")
    return lists, shared


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("files", type=pathlib.Path, nargs="+", help="the first has defines for all")
    arguments = parser.parse_args()
    body = re.search(r"\nstruct scene \{(.*?)\n\};", arguments.scene.read_text("utf-8"), re.S)[1]
    members = set(re.findall(r"(\w+)(?:\[\w+\])*(?=[;,])", re.sub(r"/\*.*?\*/", "", body)))
    common = {}
    for index, path in enumerate(arguments.files):
        lists, defines = read(path, members, common)
        for cases in lists:
            cases.write(arguments.out / f"{cases.name}.inc")
        if index == 0:
            common = defines


if __name__ == "__main__":
    main()
