# SPDX-License-Identifier: Apache-2.0
"""How the objects, programs and libraries of a build are made: ninja's commands, changed so that a
mutated object takes the place of the one without a mutation. No archive and no unmutated object is
made again."""
import os
import re
import shlex
import subprocess
from collections import namedtuple

# What the linker writes: a program or shared library, of objects and archives.
Output = namedtuple("Output", "name command objects archives")


def ninja(build, *arguments):
    return subprocess.run(["ninja", *arguments], cwd=build, check=True, stdout=subprocess.PIPE,
                          text=True).stdout


class Links:
    def __init__(self, build, target):
        self.build = build
        self.compilations, self.sources, self.outputs, self.members = {}, {}, {}, {}
        for command in ninja(build, "-t", "commands", target).splitlines():
            self.read(command)
        self.used = {}    # objects of an output, from its archives, too
        self.depends = {}  # objects of a file
        for text in ninja(build, "-t", "deps").split("\n\n"):
            name, *files = text.splitlines() or [""]
            for file in files:
                path = os.path.normpath(os.path.join(build, file.strip()))
                self.depends.setdefault(path, set()).add(name.split(":")[0])
        self.needed = {}

    def read(self, command):
        try:
            words = shlex.split(command)
        except ValueError:
            return
        if "-c" in words and "-o" in words:
            made = words[words.index("-o") + 1]
            self.compilations[made] = command
            self.sources[made] = words[words.index("-c") + 1]
        elif "qc" in words:
            at = words.index("qc")
            objects = [word for word in words[at + 1:] if word.endswith(".o")]
            members = self.members[words[at + 1]] = {}
            for name in objects:  # two folders may have a source of the same name
                members.setdefault(os.path.basename(name), set()).add(name)
        elif "-o" in words and any(word.endswith(".o") for word in words):
            name = words[words.index("-o") + 1]
            self.outputs[name] = Output(
                name, command, [word for word in words if word.endswith(".o")],
                [word for word in words if word.endswith(".a")])

    def objects_of(self, path):
        """The objects that a source or header is part of."""
        return self.depends.get(str(path), set()) & self.compilations.keys()

    def outputs_of(self, words):
        """What a test's command runs, and the shared libraries that are built with that."""
        names = {os.path.relpath(word, self.build) for word in words}
        found = sorted(names & self.outputs.keys())
        if not found:  # a script
            return [name for name in self.outputs if name.endswith("VkLayer_assay.so")]
        for name in tuple(found):
            if name not in self.needed:
                inputs = ninja(self.build, "-t", "inputs", name).splitlines()
                self.needed[name] = [word for word in inputs
                                     if word.endswith(".so") and word in self.outputs]
            found += self.needed[name]
        return found

    def objects_in(self, output):
        """All that the linker takes, as it says itself."""
        if output.name not in self.used:
            objects = set(output.objects)
            made = f"mutant/{os.path.basename(output.name)}.traced"
            os.makedirs(self.build / "mutant", exist_ok=True)
            run = subprocess.run(["sh", "-c", replaced(output.command, {output.name: made})
                                  .replace(f"-o {made}", f"-o {made} -Wl,--trace,--trace")],
                                 cwd=self.build, check=True, text=True, stdout=subprocess.PIPE)
            for archive, member in re.findall(r"^\((.+\.a)\)(.+\.o)$", run.stdout, re.MULTILINE):
                if archive in self.members:
                    objects |= self.members[archive][member]
            os.remove(self.build / made)
            self.used[output.name] = objects
        return self.used[output.name]

    # ---- commands for a mutant

    def compilation(self, made, mutated):
        """Without the note of its headers, which is ninja's."""
        command = re.sub(r" -MD -MT \S+ -MF \S+", "", self.compilations[made])
        return replaced(command, {made: mutated})

    def link(self, output, mutated):
        """With the objects in `mutated`, which leads from each to its mutant. The linker takes no
        member of an archive whose functions it has already found; some programs compile a source
        themselves for that reason."""
        own = {name: mutant for name, mutant in mutated.items() if name in output.objects}
        sources = {self.sources.get(name) for name in output.objects}
        others = [mutant for name, mutant in mutated.items()
                  if name not in own and self.sources[name] not in sources]
        command = replaced(output.command, own)
        if others:
            command = command.replace(f" {output.archives[0]}",
                                      f" {' '.join(others)} {output.archives[0]}", 1)
        return command


def replaced(command, names):
    for name, other in names.items():
        command = re.sub(rf"(?<![^\s]){re.escape(name)}(?![^\s])", lambda _, o=other: o, command)
    return command
