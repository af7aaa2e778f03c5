#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the rows of commands are complete: each command of the registry that may change what the
layer knows is observed, or layer/commands/unobserved.txt has its reason. Prints each command that is
neither, and each reason that no command needs, and fails if there is one."""

import argparse
import fnmatch
import pathlib
import re
import sys

# Objects of which the layer keeps records.
TRACKED = {"Vk" + name for name in """
    Instance Device Queue CommandPool CommandBuffer DeviceMemory Buffer Image RenderPass Semaphore Fence
    Event QueryPool DeferredOperationKHR AccelerationStructureKHR AccelerationStructureNV MicromapEXT
    DebugUtilsMessengerEXT DebugReportCallbackEXT""".split()}
# What commands in command buffers access that hazards are about, or how they order it.
RECORDED = {"Vk" + name for name in """
    Buffer DeviceAddress DeviceOrHostAddressKHR DeviceOrHostAddressConstKHR AccelerationStructureKHR
    AccelerationStructureNV MicromapEXT Event DependencyInfo RenderPass CommandBuffer""".split()}


class Registry:
    def __init__(self, registry):
        self.registry = registry
        self.cache = {}

    def types(self, name):
        """The types that a type leads to by its members, itself included."""
        if name not in self.cache:
            self.cache[name] = {name}
            structure = self.registry.structures.get(name)
            for member in structure.members if structure else []:
                self.cache[name] |= self.types(member.type)
        return self.cache[name]

    def reasons(self, command):
        """Why a command may matter."""
        parameters = command.parameters
        reached = set().union(*(self.types(parameter.type) for parameter in parameters))
        written = {p.type for p in parameters if p.pointers and not p.declaration.startswith("const")}
        if written & TRACKED and re.match("Create|Allocate|Register|Get", command.name):
            yield "creates a " + ", ".join(sorted(written & TRACKED))
        if re.match("Destroy|Free|Release", command.name) and \
                {parameter.type for parameter in parameters[1:]} & TRACKED:
            yield "destroys a " + ", ".join(sorted({p.type for p in parameters[1:]} & TRACKED))
        if command.name.startswith("Cmd") and reached & RECORDED - {"VkCommandBuffer"}:
            yield "records " + ", ".join(sorted(reached & RECORDED - {"VkCommandBuffer"}))
        if not command.name.startswith("Cmd") and reached & {"VkSemaphore", "VkFence"}:
            yield "has a " + ", ".join(sorted(reached & {"VkSemaphore", "VkFence"}))
        if re.match(r"(Import|Export)|Get(Memory|Semaphore|Fence)\w*(Fd|Handle|Metal|Buffer)",
                    command.name):
            yield "imports or exports"
        if "VK_ERROR_DEVICE_LOST" in command.errors:
            yield "can return VK_ERROR_DEVICE_LOST"
        if re.search("Wait|Acquire|Sleep", command.name) and not command.name.startswith("Cmd"):
            yield "waits"
        if command.name.startswith("Queue"):
            yield "uses a queue"


def read_reasons(path):
    """Pairs of a pattern of names and a reason."""
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return [tuple(part.strip() for part in line.split(":", 1)) for line in lines]


def find_problems(root, registry, rows):
    """Yields what is wrong."""
    folder = root / "layer/commands"
    observed = {command.name for file in sorted((folder / "rows").glob("*.def"))
                for row in rows.read_rows(file) for command in rows.commands_of(registry, row)}
    reasons, needed, used = read_reasons(folder / "unobserved.txt"), Registry(registry), set()
    for command in registry.commands.values():
        why = "; ".join(needed.reasons(command))
        if not why or command.name in observed:
            continue
        pattern = next((p for p, _ in reasons if fnmatch.fnmatchcase("vk" + command.name, p)), None)
        used.add(pattern)
        if not pattern:
            yield f"vk{command.name} has no row and no reason in unobserved.txt: it {why}"
    for pattern, _ in reasons:
        if pattern not in used:
            yield f"unobserved.txt: no command needs the line of {pattern}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path, help="the repository")
    root = parser.parse_args().root
    # scripts/setup unpacks it only if the system's is too old.
    places = [root / "build/deps/usr/share/vulkan/registry/vk.xml",
              pathlib.Path("/usr/share/vulkan/registry/vk.xml")]
    path = next(filter(pathlib.Path.exists, places), None)
    if not path:
        sys.exit("commands: there is no registry of Vulkan: run scripts/setup first")
    sys.path += [str(root / "vuid-tables"), str(root / "layer/commands")]
    import rows
    import signatures
    problems = sorted(find_problems(root, signatures.Registry(path), rows))
    print("\n".join(problems) or "commands: each one that may matter has a row or a reason")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
