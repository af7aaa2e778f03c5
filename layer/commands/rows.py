# SPDX-License-Identifier: Apache-2.0
"""Reads the files of layer/commands/rows/."""

import copy
import re


class Value:
    """A local variable of an entry, which an observer before the call gives to one behind it."""

    def __init__(self, declaration):
        self.type, self.name = re.fullmatch(r"(.+?)\s*\b(\w+)", declaration).groups()


class Call:
    """The call of an observer, as a row writes it: [[TYPE] NAME =] FUNCTION(ARGUMENT, ...)."""

    def __init__(self, text):
        written = re.fullmatch(r"(?:([^=()]+?) = )?(\w+\(.*\))", text)
        if not written:
            raise ValueError(f"an observer is FUNCTION(ARGUMENT, ...), not: {text}")
        target, call = written.groups()
        self.gives = Value(target) if target and " " in target else None
        self.sets_result = target == "result"
        if target and not self.gives and not self.sets_result:
            raise ValueError(f"an observer sets neither a new variable nor the result: {text}")
        self.function, arguments = re.fullmatch(r"(\w+)\((.*)\)", call).groups()
        self.arguments = split(arguments)
        self.is_lowered = False  # whether it has the parameters of the newer command


class Accesses:
    """What a command reads and writes, in the order of the row: KIND, ROLE, PLACE(ARGUMENT, ...). The
    arguments are statements of C; ARRAY[COUNT] is each of so many elements."""
    gives, sets_result, function, is_lowered = None, False, None, False

    def __init__(self):
        self.arguments = []

    def add(self, keyword, text):
        kind, role, place = split(text)
        name, arguments = re.fullmatch(r"(\w+)\((.*)\)", place).groups()
        array = re.search(r"\[(\w+)\]", arguments)
        each = f"for (uint32_t i = 0; i < {array[1]}; i++) " if array else ""
        self.arguments.append(
            f"{each}hazards_access_{name}(&recording, ACCESS_{kind}_{keyword[:-1]}, HAZARD_{role}, "
            f"{arguments.replace(array[0], '[i]') if array else arguments});")


class Newer:
    """The command whose row says what observes an older one: COMMAND[, NAME = VALUE ...]. The values are of
    parameters of the newer command, and of members of their structures, as expressions of C."""

    def __init__(self, text):
        self.command, *given = split(text)
        self.given = dict(re.fullmatch(r"(\w+) = (.+)", value).groups() for value in given)


class Row:
    """One command: its name without vk, and its parts in the order in which they are written."""

    def __init__(self, name):
        self.name = name
        self.flags = set()
        self.observers = []   # pairs of a keyword and a Call
        self.extension = None  # of backend cpu, which supplies the command
        self.newer = None      # of AS()
        self.accesses = Accesses()

    def calls(self, keyword):
        return [call for of, call in self.observers if of == keyword]

    def observe_accesses(self):
        """They are recorded before the call, or behind one in a command buffer which may be skipped."""
        is_behind = self.name.startswith("Cmd") and self.calls("UNLESS")
        if self.accesses.arguments:
            self.observers.append(("HAZARDS_AFTER" if is_behind else "HAZARDS", self.accesses))

    def has(self, flag):
        return flag in self.flags

    def uses(self, condition):
        """Whether something of the row depends on a condition."""
        keywords = [*self.flags, *(keyword for keyword, _ in self.observers)]
        return any(keyword.startswith(condition) for keyword in keywords) or \
            (condition == "CALL_SITES" and (self.has("CHECKED") or self.has("HAZARDS_CALL_SITES"))) or \
            (condition == "CPU" and self.extension is not None)


def split(text):
    """The parts between commas outside of parentheses."""
    parts, depth = [""], 0
    for character in text:
        depth += (character == "(") - (character == ")")
        if character == "," and not depth:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]


def inside(text, start):
    """The text in the parentheses that open at `start`, and the index behind them."""
    depth = 0
    for at in range(start, len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if not depth:
            return text[start + 1:at], at + 1
    raise ValueError("a parenthesis is not closed: " + text[start:start + 60])


FLAGS = ("ALONE", "BY_HAND", "CALL_SITES", "CHECKED", "CONTENT_REPLACES", "CPU_MASKS", "HAZARDS_CALL_SITES", "IF_PRESENT",
         "MAY_LOSE_DEVICE", "ON_RECORDING_PATH", "REQUIRED")
OBSERVERS = ("HAZARDS", "BEFORE", "UNLESS", "CONTENT", "THROUGH", "CONTENT_THROUGH", "CONTENT_SUCCESS",
             "CONTENT_AFTER", "SUCCESS", "AFTER", "HAZARDS_SUCCESS", "HAZARDS_AFTER", "CPU_IF", "CPU")
# What makes or replaces the call of the next layer: each version of a command has its own.
CALLS = ("THROUGH", "CONTENT_THROUGH", "CPU_IF", "CPU")


def read_rows(path):
    text = " ".join(re.sub(r"/\*.*?\*/", " ", path.read_text(), flags=re.S).split())
    rows, at = [], 0
    while at < len(text):
        word = re.compile(r"\s*(\w+)").match(text, at)
        if not word:
            raise ValueError("expected a keyword: " + text[at:at + 60])
        at, argument = word.end(), None
        if text[at:at + 1] == "(":
            argument, at = inside(text, at)
        if word[1] == "COMMAND":
            rows.append(Row(argument))
        elif word[1] in FLAGS and not argument:
            rows[-1].flags.add(word[1])
        elif word[1] in OBSERVERS and argument:
            rows[-1].observers.append((word[1], Call(argument)))
        elif word[1] == "CPU_SUPPLIES" and argument:
            rows[-1].extension = argument
        elif word[1] in ("READS", "WRITES") and argument:
            rows[-1].accesses.add(word[1], argument)
        elif word[1] == "AS" and argument:
            rows[-1].newer = Newer(argument)
        else:
            raise ValueError(f"{path.name}: unknown keyword {word[1]}")
        at = len(text) if not text[at:].strip() else at
    for row in rows:
        row.observe_accesses()
    return rows


def observe_as_newer(row, newer):
    """Adds the keywords and the observers of the newer command's row."""
    row.flags |= newer.flags
    for keyword, call in newer.observers:
        if keyword not in CALLS:
            call = copy.copy(call)
            call.is_lowered = True
            row.observers.append((keyword, call))
        elif keyword.endswith("THROUGH") and not row.calls(keyword):
            raise ValueError(f"{row.name} has no {keyword} of its own")


def read_files(paths):
    """The rows of all files. A command has one."""
    rows = [row for path in paths for row in read_rows(path)]
    by_name = {row.name: row for row in rows}
    for row in rows:
        if row.newer and (row.newer.command not in by_name or by_name[row.newer.command].newer):
            raise ValueError(f"{row.name} is observed as {row.newer.command}, which has no observers")
        if row.newer:
            observe_as_newer(row, by_name[row.newer.command])
    names = [row.name for row in rows]
    for name in set(names):
        if names.count(name) > 1:
            raise ValueError(f"{name} has two rows")
    return rows


def commands_of(registry, row):
    """The command of a row, and those that are aliases of the same command."""
    own = registry.commands.get(row.name)
    if not own:
        raise ValueError(f"the registry has no vk{row.name}")
    return [command for command in registry.commands.values() if command is own or
            (command.target == own.target and not row.flags & {"ALONE", "BY_HAND"})]
