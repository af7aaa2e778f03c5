# SPDX-License-Identifier: Apache-2.0
"""Runs the test programs with a layer, and reads what they print of each play of a case."""

import collections
import os
import pathlib
import re
import resource
import subprocess

# What the test programs print of one play at most.
MESSAGES_PRINTED, TEXT_PRINTED = 12, 16000
SECONDS_A_LIST, SECONDS_A_PLAY = 300, 20
MEMORY = 2 << 30  # bytes that a program may use: a layer may follow a chain that never ends

RUN = re.compile(r"\[ RUN      \] (.+)$")
END = re.compile(r"\[ ( *\w+) +\] (crashed in )?(.+)$")
BEFORE_THE_CALL = re.compile(r"the call: \d+ messages before it$")
GOT = re.compile(r"    (?:got|expected) (\S*)$")
MISSING = re.compile(r"no message is (\S+): ")
MESSAGES_END = re.compile(r"tests/programs/|execution/\w+: ")

# Plays at levels that the Khronos layer does not have, and repetitions.
REPEATED = re.compile(r"@(parameters|state)$|\+ppGeometries$")

Message = collections.namedtuple("Message", "id text")


def is_case(name):
    """True for a program of a call."""
    return name.startswith("calls/")


class Play:
    """What a program printed of one play."""

    def __init__(self, name):
        self.name = name
        self.outcome = "crashed"  # or passed, failed, skipped, hung
        self.reason = ""          # why it was skipped
        self.messages = []
        self.is_early = False     # it ended before the call
        self.missing = set()      # ids that were expected
        self.text = ""

    def found_all(self):
        """True if the program of a call had all messages that it should have, though they are not
        printed: it failed for something else."""
        is_printed = self.messages and len(self.text) < TEXT_PRINTED and len(self.messages) < MESSAGES_PRINTED
        return is_case(self.name) and not is_printed and not self.missing and not self.is_early

    def read(self, lines):
        """Reads the lines between the play's name and its outcome."""
        is_message = False
        for line in lines:
            if BEFORE_THE_CALL.match(line):
                self.is_early = True
            if MESSAGES_END.match(line):
                is_message = False
            if MISSING.match(line):
                self.missing.add(MISSING.match(line)[1])
            if GOT.match(line):
                self.messages.append(Message(GOT.match(line)[1], ""))
                is_message = True
            elif is_message:
                last = self.messages[-1]
                self.messages[-1] = last._replace(text=last.text + line.strip() + " ")
        self.text = "\n".join(lines)


def read_plays(output):
    """The plays in a program's output; the last may have crashed."""
    plays, lines, play = [], [], None
    for line in output.splitlines():
        run, end = RUN.match(line), END.match(line)
        if run:
            play, lines = Play(run[1]), []
            plays.append(play)
        elif play and end and (end[3] == play.name or end[3].startswith(play.name + ": ")):
            play.outcome = {"OK": "passed", "SKIPPED": "skipped"}.get(end[1].strip(), "failed")
            if end[2]:
                play.outcome = "crashed"
            play.reason = end[3][len(play.name) + 2:]
            play.read(lines)
            play = None
        elif play:
            lines.append(line)
    return plays


# ---- running programs

def environment(layer):
    """Variables for a program: none of the caller's that are Vulkan's, and the layer's."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("VK_")}
    return {**kept, **layer}


def limit_memory():
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(program, layer, name, seconds, results=None):
    """The plays whose names contain `name`, and whether the program came to its end."""
    command = [*program, "--verbose", "--filter", name]
    if results:
        command += ["--results", str(results)]
    try:
        done = subprocess.run(command, env=environment(layer), timeout=seconds, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace",
                              preexec_fn=limit_memory)
    except subprocess.TimeoutExpired as error:
        plays = read_plays((error.stdout or b"").decode(errors="replace"))
        if plays and plays[-1].outcome == "crashed":
            plays[-1].outcome = "hung"
        return plays, False
    return read_plays(done.stdout), done.returncode in (0, 1)


def list_of(name):
    """The start of the names of a file of programs."""
    return name.split(": ")[0] + ": "


def twin_of(name):
    return name + " (repaired)"


def names_of(program):
    """The plays to compare of a program, by list."""
    lists = collections.defaultdict(list)
    done = subprocess.run([*program, "--list"], env=environment({}), check=False,
                          stdout=subprocess.PIPE, text=True)
    for line in done.stdout.splitlines() if done.returncode == 0 else ():
        if not line.startswith("[") and not REPEATED.search(line):
            lists[list_of(line)].append(line)
    return lists


def play_list(program, layer, list_name, names, each):
    """All plays of a list in one process. If that crashes, the rest in one process each: what a
    crash hides may be the state that earlier plays left behind."""
    plays = {}
    if not each:
        played, ended = run(program, layer, list_name, SECONDS_A_LIST)
        plays = {play.name: play for play in played}
        if ended:
            return plays
    for name in names:
        if name in plays and plays[name].outcome != "crashed":
            continue
        for play in run(program, layer, name, SECONDS_A_PLAY)[0]:
            if play.name == name or play.name not in plays:
                plays[play.name] = play
    return plays


def read_expectations(program, list_name, folder):
    """Assay's plays of a list; and name of the play -> ids that the play breaks, if it does."""
    results = pathlib.Path(folder) / "results.tsv"
    plays, _ = run(program, {}, list_name, SECONDS_A_LIST, results)
    expected = collections.defaultdict(list)
    for line in results.read_text().splitlines():
        _, case, command, name, outcome = line.split("\t")
        key = case if case.startswith(list_name) else f"{list_name}{case}/{command}"
        if outcome != "silent" and name not in expected[key]:
            expected[key].append(name)
    return {play.name: play for play in plays}, expected
