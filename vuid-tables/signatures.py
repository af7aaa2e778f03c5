# SPDX-License-Identifier: Apache-2.0
"""The signatures of commands, and the members of structures, from the registry."""

import re
import sys
import xml.etree.ElementTree as ElementTree


def is_of_vulkan(element):
    return "vulkan" in (element.get("api") or "vulkan").split(",")


def read_commands(path):
    """The names of commands.def. A command that is recorded has columns."""
    text = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)
    rows = re.findall(r"^(COMMAND|JOURNALED)\((\w+)", text, re.M)
    for macro, name in rows:
        if macro == "COMMAND" and name.startswith("Cmd"):
            sys.exit(f"{path}: {name} is recorded, and has no row JOURNALED")
    return [name for _, name in rows]


class Member:
    """A parameter of a command, or a member of a structure."""

    def __init__(self, element):
        for comment in element.findall("comment"):
            element.remove(comment)
        self.name = element.findtext("name")
        self.type = element.findtext("type")
        self.declaration = " ".join("".join(element.itertext()).split())
        self.pointers = self.declaration.count("*")
        self.is_array = "[" in self.declaration
        self.values = element.get("values")
        self.is_ignored = element.get("deprecated") == "ignored"
        self.is_const = self.declaration.startswith("const ")
        self.no_auto_validity = element.get("noautovalidity") == "true"
        self.may_be_null = (element.get("optional") or "").split(",")[0] == "true"
        self.elements_may_be_null = self.pointers == 1 and \
            (element.get("optional") or "").split(",")[1:] == ["true"]
        # A union: the member that says which one counts; a member of a union: for which values it counts.
        self.selector = element.get("selector")
        self.selection = (element.get("selection") or "").split(",")
        # The number of elements of each level of pointers.
        self.lengths = (element.get("altlen") or element.get("len") or "").split(",")

    def length(self, prefix, members):
        """The number of elements as an expression of C, "null-terminated", or "" for one."""
        names = {member.name for member in members}
        return self.lengths[0] if self.lengths[0] == "null-terminated" else re.sub(
            r"(?<!->)\b[A-Za-z_]\w*", lambda name: prefix + name[0] if name[0] in names else name[0],
            self.lengths[0])

    def counts(self, members):
        """The member that is the number of elements, or None."""
        return next((member for member in members if member.name == self.lengths[0]), None)


class Command:
    def __init__(self, name, target, element):
        self.name = name
        self.target = target  # the command of which this one is an alias, or its own name
        self.protect = None   # the macro of the platform without which the headers lack the command
        self.errors = (element.get("errorcodes") or "").split(",")
        self.returns = element.findtext("proto/type")
        self.queues = (element.get("queues") or "").split(",") if element.get("queues") else []
        self.render_pass = element.get("renderpass")
        self.parameters = [Member(parameter) for parameter in element.iterfind("param")
                           if is_of_vulkan(parameter)]
        self.declaration = ", ".join(parameter.declaration for parameter in self.parameters)
        self.arguments = ", ".join(parameter.name for parameter in self.parameters)


class Structure:
    def __init__(self, element):
        self.name = element.get("name")
        self.is_union = element.get("category") == "union"
        self.members = [Member(member) for member in element.iterfind("member")
                        if is_of_vulkan(member)]
        self.type = self.members[0].values
        self.extends = (element.get("structextends") or "").split(",")
        self.has_chain = any(member.name == "pNext" for member in self.members)


def blocks_of(tree):
    """The core versions and extensions of Vulkan, without those of one platform."""
    for block in [*tree.iterfind("feature"), *tree.iterfind("extensions/extension")]:
        apis = block.get("api" if block.tag == "feature" else "supported").split(",")
        if "vulkan" in apis and block.get("platform") in (None, "provisional"):
            yield block


def owners_of(tree):
    """Maps each type to the core versions and extensions that have it."""
    owners = {}
    for block in blocks_of(tree):
        for name in block.iterfind("require/type"):
            owners.setdefault(name.get("name"), set()).add(block.get("name"))
    return owners


class Registry:
    def __init__(self, path):
        self.tree = tree = ElementTree.parse(path)
        commands = {}
        aliases = {}
        for element in tree.iterfind("commands/command"):
            if element.get("alias"):
                aliases[element.get("name")] = element.get("alias")
            elif is_of_vulkan(element):
                commands[element.findtext("proto/name")] = element
        aliases |= {name: name for name in commands}
        self.commands = {name[2:]: Command(name[2:], target[2:], commands[target])
                         for name, target in aliases.items()}
        self.find_platforms(tree)
        self.structures, self.handles, others = {}, {}, {}
        self.enums, self.bitmasks = set(), {}
        self.owners = owners_of(tree)
        self.values = {}  # of enums and of the bits of flags: pairs of a name and its owners
        for element in tree.iterfind("enums[@type]"):
            self.values[element.get("name")] = [
                (value.get("name"), set()) for value in element.iterfind("enum")
                if not value.get("alias")]
        self.add_values(tree)
        for element in tree.iterfind("types/type"):
            name = element.get("name") or element.findtext("name")
            if element.get("alias"):
                others[name] = element.get("alias")
            elif element.get("category") in ("struct", "union"):
                self.structures[name] = Structure(element)
            elif element.get("category") == "handle":
                self.handles[name] = element.get("objtypeenum")
            elif element.get("category") == "enum":
                self.enums.add(name)
            elif element.get("category") == "bitmask":
                self.bitmasks[name] = element.get("requires") or element.get("bitvalues")
        for name, target in others.items():
            for table in (self.structures, self.handles, self.bitmasks):
                if target in table:
                    table[name] = table[target]
            if target in self.enums:
                self.enums.add(name)
        self.aliases = others

    def add_values(self, tree):
        """Adds the values that extensions define. Those of the enum itself have no owners."""
        for block in blocks_of(tree):
            for value in block.iterfind("require/enum[@extends]"):
                known = dict(self.values.get(value.get("extends"), ()))
                target = value.get("alias") or value.get("name")
                if target not in known and not value.get("alias") and value.get("extends") in self.values:
                    self.values[value.get("extends")].append((target, {block.get("name")}))
                elif known.get(target):
                    known[target].add(block.get("name"))

    def kind_of(self, name):
        """What a type is: handle, enum, bitmask or None. Structures are in `structures`."""
        return "handle" if name in self.handles else "enum" if name in self.enums else \
            "bitmask" if name in self.bitmasks else None

    def bits_of(self, name):
        """The type that has the bits of flags; None if the flags have none."""
        return self.bitmasks[name]

    def find_platforms(self, tree):
        macros = {platform.get("name"): platform.get("protect")
                  for platform in tree.iterfind("platforms/platform")}
        for extension in tree.iterfind("extensions/extension[@platform]"):
            for command in extension.iterfind("require/command"):
                if command.get("name")[2:] in self.commands:
                    self.commands[command.get("name")[2:]].protect = macros[extension.get("platform")]
