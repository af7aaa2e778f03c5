# SPDX-License-Identifier: Apache-2.0
"""Writes what the ids of implicit.py say as tables of C; src/check/life/implicit.h has their types."""

import re
from collections import namedtuple

# tail: of the id. kind: that of its check. members: those that it is about.
Id = namedtuple("Id", "tail level kind members")

# What nothing in a call decides.
UNDECIDABLE = {"REPLAYED": "undecidable: a replayed address comes from another run of the application"}


def hint(scope, id_):
    member = id_.members[0] if id_.members else None
    if id_.kind == "LENGTH":
        return "Pass the size of the memory in bytes." if member.name == "dataSize" else \
            "Pass at least one element, or omit the call." if scope.is_command else \
            "Write at least one element."
    if id_.kind == "POINTER" and member.type == "VkAllocationCallbacks":
        return "Pass NULL, or a pointer to VkAllocationCallbacks."
    return {"STYPE": f"Set sType to {member.values if member else ''}.",
            "CHAIN": "Chain only structures that the specification lists for this one, and enable "
                     "their extensions.",
            "UNIQUE": "Chain each structure once.",
            "ENUM": f"Set {member and member.name} to a {member and member.type} value, and "
                    "enable its extension.",
            "FLAGS": "Clear these bits, or enable the extension that defines them.",
            "ZERO": f"Set {member and member.name} to 0.",
            "POINTER": f"Point {member and member.name} to memory that has all that it leads to.",
            "SELECTED": f"Point {member and member.name} to memory that has all that it leads to.",
            "ADDRESS": f"Set {member and member.name} to an address that vkGetBufferDeviceAddress "
                       "returned, or to one in that VkBuffer.",
            "HANDLE": f"Pass a {member and member.type} that was created and is not "
                      "destroyed.",
            "EMBEDDED": f"Fill in {member and member.name}, its sType included.",
            "PARENT": "Use objects that were created from the VkDevice that executes the command.",
            "QUEUES": "Create the VkDevice with a queue."}[id_.kind]


class Tables:
    def __init__(self, usage, scopes, shared):
        self.usage, self.registry, self.shared = usage, usage.registry, shared
        self.scopes = {scope.name: scope for scope in scopes if scope.ids}
        self.owners = []   # names of extensions, by the number of their bit
        self.values = {}   # texts of tables of values, by their names
        self.chained = set()  # structures in scope that others chain

    # ---- values

    def bits(self, owners):
        """The bits of extensions, as an expression of C. What a core version has needs none."""
        if any("_VERSION_" in owner for owner in owners):
            return "0"
        for owner in sorted(owners):
            if owner not in self.owners:
                self.owners.append(owner)
        if len(self.owners) > 64:
            raise ValueError("more than 64 extensions own values")
        return " | ".join(f"UINT64_C(1) << {self.owners.index(owner)}"
                          for owner in sorted(owners)) or "0"

    def values_of(self, type_name):
        """The name of the table of the values of an enum, or of the bits of flags."""
        type_name = self.registry.aliases.get(type_name, type_name)
        kind = self.registry.bits_of(type_name) if self.registry.kind_of(type_name) == "bitmask" \
            else type_name
        rows = "".join(f'    {{(uint64_t){name}, {self.bits(owners)}, "{name}", NULL}},\n'
                       for name, owners in self.registry.values[kind])
        return self.table(kind, rows)

    def chain_of(self, name):
        """The name of the table of the structures that a chain may have."""
        rows = ""
        for other in self.usage.extensions(name):
            scope = f"&scope_of_{other}" if other in self.scopes else "NULL"
            if scope != "NULL":
                self.chained.add(other)
            rows += f'    {{{self.registry.structures[other].type}, ' \
                    f'{self.bits(self.registry.owners[other])}, "{other}", {scope}}},\n'
        return self.table(f"{name}_chain", rows)

    def table(self, name, rows):
        self.values[name] = f"static const struct implicit_value values_of_{name}[] = {{\n{rows}}};\n\n" \
            if rows else f"enum {{ values_of_{name}_count = 0 }};\n\n"
        if not rows:
            return ".values = NULL, .value_count = 0"
        return f".values = values_of_{name}, .value_count = " \
               f"sizeof(values_of_{name}) / sizeof(values_of_{name}[0])"

    # ---- checks

    def length(self, member, members, structure, prefix):
        """The number of elements of an array, as fields of C."""
        length = member.lengths[0]
        counts = member.counts(members)
        if counts:
            place = f"{prefix}{counts.name}"
            return f".count_at = offsetof({structure}, {place}), " \
                   f".count_size = sizeof((({structure} *)0)->{place})"
        if "->" in length:
            pointer, name = length.split("->")
            target = next(other.type for other in members if other.name == pointer)
            return f".count_at = offsetof({target}, {name}), .count_size = sizeof((({target} *)0)->{name}), " \
                   f".counts_through = true, .pointer_at = offsetof({structure}, {prefix}{pointer})"
        return f".count = {length}" if length else ".count = 1"

    def check(self, rule, kind, member, members, structure, prefix="", more=(), owner=None):
        """One row of a table: what is checked of one member, which `owner` has: a part of `structure`."""
        place = f"{prefix}{member.name}"
        is_array = bool(member.pointers and member.lengths[0])
        chained = f"pNext<{structure}>." if structure in self.chained else \
            getattr(self.scopes.get(structure), "place", None) or ""
        field = chained + place + ("[]" if kind in ("HANDLE", "PARENT") and member.pointers else "")
        element = "1" if member.type == "void" else \
            "sizeof(void *)" if member.pointers > 1 else f"sizeof({member.type})"
        parts = [f".rule = RULE_{rule}", f".kind = IMPLICIT_{kind}", f'.field = "{field}"',
                 f'.parameter = "{place}"', f".at = offsetof({structure}, {place})",
                 f".size = sizeof((({structure} *)0)->{place})"]
        if member.pointers and kind not in ("CHAIN", "UNIQUE"):
            parts += [".is_pointer = true", f".element = {element}",
                      self.length(member, members, structure, prefix)]
            if member.pointers > 1:
                parts.append(f".pointee = sizeof({member.type})")
        parts += [".is_optional = true"] if member.may_be_null else []
        parts += [".elements_are_optional = true"] if member.elements_may_be_null else []
        parts += [".is_array = true"] if is_array else []
        parts += [*self.details(kind, member, owner or structure), *more]
        return f"    {{{', '.join(parts)}}},\n"

    def details(self, kind, member, structure):
        if kind == "STYPE":
            return [f".value = {member.values}"]
        if kind in ("CHAIN", "UNIQUE"):
            return [self.chain_of(structure)]
        if kind in ("ENUM", "FLAGS"):
            return [f'.type = "{member.type}"', self.values_of(member.type)]
        if kind in ("HANDLE", "PARENT"):
            return [f'.type = "{member.type}"', f".value = {self.registry.handles[member.type]}"]
        return []

    def embedded(self, rule, member, structure):
        """A structure by value, whose checks report the id of the member."""
        inner = self.registry.structures[member.type]
        prefix = f"{member.name}."
        for other in inner.members:
            kind = self.registry.kind_of(other.type)
            check = "STYPE" if other.values else {"enum": "ENUM", "bitmask": "FLAGS"}.get(kind) or \
                ("POINTER" if other.pointers and other.name != "pNext" else None)
            if check:
                yield self.check(rule, check, other, inner.members, structure, prefix)

    def selected(self, option, member, structure, prefix):
        """The fields of C that say when a member of a union counts."""
        values = " | ".join(f"1u << {value}" for value in option.selection)
        return [f".selections = {values}", f".selector_at = offsetof({structure}, {prefix}{member.selector})"]

    def checks(self, scope, structure=None, prefix="", more=()):
        """The rows of a scope. `structure`, `prefix`: it is that part of another structure."""
        structure = structure or (f"struct arguments_of_{scope.name[2:]}" if scope.is_command else scope.name)
        for id_ in scope.ids:
            rule = f"{scope.name}_{id_.tail}"
            if id_.kind in ("CALL", *UNDECIDABLE) or (scope.is_command and id_.tail in self.shared):
                continue
            if id_.kind == "QUEUES":
                yield f'    {{.rule = RULE_{rule}, .kind = IMPLICIT_QUEUES, .field = "device"}},\n'
            elif id_.kind == "EMBEDDED" and id_.members[0].type in self.scopes:
                yield from self.checks(self.scopes[id_.members[0].type], structure,
                                       f"{prefix}{id_.members[0].name}.", [f".also = 1 + RULE_{rule}"])
            elif id_.kind == "EMBEDDED":
                yield from self.embedded(rule, id_.members[0], structure)
            elif id_.kind == "SELECTED":
                option, member = id_.members
                yield self.check(rule, "POINTER", option, scope.members, structure, f"{prefix}{member.name}.",
                                 [*more, *self.selected(option, member, structure, prefix)])
            else:
                for member in id_.members:
                    owner = scope.name if prefix else structure
                    details = () if id_.kind in ("CHAIN", "UNIQUE") else more
                    yield self.check(rule, id_.kind, member, scope.members, structure, prefix, details, owner)

    def parameter_of(self, name):
        """The parameter that leads to a structure."""
        return next((f"{member.name}->" for scope in self.scopes.values() if scope.is_command
                     for member in scope.members if member.pointers and member.type == name), "")

    def visits(self, scope, structure=None, prefix="", path=""):
        """What the parameters of a command lead to, and the unions of a structure."""
        structure = structure or (f"struct arguments_of_{scope.name[2:]}" if scope.is_command else scope.name)
        for member in scope.members:
            place = f"{prefix}{member.name}"
            if scope.is_command and member.pointers == 1 and member.type in self.scopes:
                counts = member.counts(scope.members)
                yield f'    {{.parameter = "{place}", .at = offsetof({structure}, {place}), ' \
                      f".scope = &scope_of_{member.type}, .is_array = {'true' if member.lengths[0] else 'false'}, " \
                      f".count_at = {f'offsetof({structure}, {counts.name})' if counts else '0'}}},\n"
            elif not scope.is_command and not member.pointers and member.type in self.scopes:
                yield from self.visits(self.scopes[member.type], structure, f"{place}.", path)
            for option in self.registry.structures[member.type].members if member.selector else ():
                fields = ", ".join(self.selected(option, member, structure, prefix))
                yield f'    {{.parameter = "{path}{place}.{option.name}", ' \
                      f".at = offsetof({structure}, {place}.{option.name}), " \
                      f".scope = &scope_of_{option.type}, {fields}}},\n"

    # ---- texts

    def scope_text(self, scope):
        checks = "".join(self.checks(scope))
        visits = "".join(self.visits(scope, path=self.parameter_of(scope.name)))
        structure = f"struct arguments_of_{scope.name[2:]}" if scope.is_command else scope.name
        out = f"static const struct implicit_check checks_of_{scope.name}[] = {{\n{checks}}};\n" \
            if checks else ""
        if visits:
            out += f"static const struct implicit_visit visits_of_{scope.name}[] = {{\n{visits}}};\n"
        parts = [f".size = sizeof({structure})"]
        for table, text in (("check", checks), ("visit", visits)):
            if text:
                parts += [f".{table}s = {table}s_of_{scope.name}",
                          f".{table}_count = sizeof({table}s_of_{scope.name}) / "
                          f"sizeof({table}s_of_{scope.name}[0])"]
        return f"{out}static const struct implicit_scope scope_of_{scope.name} = {{{', '.join(parts)}}};\n\n"

    def text(self):
        structures = [scope for scope in self.scopes.values() if not scope.is_command]
        for scope in self.scopes.values():  # finds values and chained structures
            "".join(self.checks(scope))
        descriptors = self.chain_of("VkWriteDescriptorSet")
        first = sorted(structures, key=lambda scope: scope.name not in self.chained)
        chained = [scope for scope in first if scope.name in self.chained]
        # Backwards, what structures lead to comes before them.
        others = [scope for scope in reversed(first) if scope.name not in self.chained]
        commands = [scope for scope in self.scopes.values() if scope.is_command]
        plain = {name: text for name, text in self.values.items() if "&scope_of" not in text}
        with_scopes = {name: text for name, text in self.values.items() if "&scope_of" in text}
        table = "".join(f"    [COMMAND_{scope.name[2:]}] = &scope_of_{scope.name},\n" for scope in commands)
        read = "".join(f'    {{"{scope.name}", &scope_of_{scope.name}}},\n'
                       for scope in structures if scope.place is not None)
        return "".join([
            *plain.values(), *map(self.scope_text, chained), *with_scopes.values(),
            *map(self.scope_text, others), *map(self.scope_text, commands),
            "static const struct implicit_check chain_of_descriptors = {\n    ",
            f"{descriptors}}};\n\n",
            f"static const struct implicit_read scopes_in_device_memory[] = {{\n{read}}};\n\n",
            "static const struct implicit_scope *const scope_of_command[COMMAND_COUNT] = {\n",
            table, "};\n"])

    def owners_text(self):
        names = "".join(f'    "{name}",\n' for name in self.owners)
        return f"const char *const registry_owners[] = {{\n{names}}};\n\n" \
               f"const size_t registry_owner_count = {len(self.owners)};\n"
