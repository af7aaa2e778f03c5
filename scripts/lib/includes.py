#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the #include lines of layer/, src/ and vuid-tables/: a file may include files of its own
folder and of folders below it in FOLDERS; no files include each other in a circle (a source and its
header count as one file); no other folder includes those of CONSUMERS; a folder holds at most FILES_MAX
files; a file's name doesn't repeat its folder's; outside PLATFORM and PROGRAM, no file includes a header of a system, calls a function that only some
systems have, or asks which system or compiler it is compiled for. In these folders, and in tests/ and
scripts/tools/, each source includes what it needs of PRECOMPILED. Prints each offender, and fails if
there is one."""

import argparse
import collections
import fnmatch
import os
import pathlib
import re
import sys

# From the ground up. A folder that isn't listed stands where the folder that holds it does.
FOLDERS = (
    "vuid-tables",
    "src/platform",
    "src/base",
    "src/bvh",
    "src/hazards",
    "src/shaders",
    "src/model",
    "src/state",
    "src/view",
    "src/rules",
    "src/snapshots",
    "src/check",
    "src/report",
    "src/cpu",
    "src/advice",
    "src/compare",
    "src/capture",
    "src/scene",
    "layer",
    "layer/snapshots",
    "layer/cpu",
    "layer/cpu/driver",
    "layer/compare",
    "layer/hazards/executed",
    "layer/advice",
    "layer/execution",
    "layer/capture",
    "layer/postmortem",
    "layer/intercepts",
    "layer/hazards",
    "layer/commands",
    "layer/lifecycle",
)
# Options of CMake leave them out. "*": src/ or layer/.
CONSUMERS = ("*/advice/*", "*/compare/*", "*/capture/*", "*/scene/*")
PLATFORM = "src/platform"
# A program that Windows does not have.
PROGRAM = "src/scene"
# What all systems have: of C11 all but <time.h> and <threads.h>, whose place clock.h and threads.h of
# PLATFORM take; <unwind.h>, which comes with the compiler; and the libraries.
PLAIN_HEADERS = frozenset(
    """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp stdalign stdarg
    stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath uchar wchar wctype unwind
    immintrin""".split())
PLAIN_FOLDERS = ("vulkan/", "vk_video/", "xxhash.h", "jansson.h")
# What scripts/lib/precompile.cmake puts before all sources, so that their compilation does not show that they
# lack it: words, and headers of which a source that has such words includes one, or a file that does.
PRECOMPILED = (
    (re.compile(r"\b(?:Vk[A-Z]\w+|VK_[A-Z]\w+|PFN_vk\w+)"), ("vulkan/",)),
    (re.compile(r"\bu?int(?:8|16|32|64|ptr)_t\b"), ("vulkan/", "stdint.h", "inttypes.h")),
    (re.compile(r"\bsize_t\b"), ("vulkan/", "stddef.h", "stdlib.h", "stdio.h", "string.h")),
)
COMMENT_OR_STRING = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', re.S)
FILES_MAX = 25
SOURCES = (".c", ".h")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
SYSTEM_INCLUDE = re.compile(r'^\s*#\s*include\s+<([^>]+)>', re.M)
SYSTEM_MACRO = re.compile(r"^\s*#\s*(?:el)?if.*\b(_WIN\w+|WIN32|__(?:linux|unix|APPLE|ANDROID|MINGW\w*|GLIBC|FreeBSD)_*)\b"
                          r"|^\s*#\s*define\s+(_GNU_SOURCE|_DEFAULT_SOURCE|_POSIX_C_SOURCE)\b", re.M)
# Functions that Linux declares in PLAIN_HEADERS and Windows lacks.
SYSTEM_CALL = re.compile(
    r"(?<![\w.>])((?:aligned_alloc|posix_memalign|secure_getenv|setenv|unsetenv|realpath|mkstemp|mkdtemp"
    r"|strndup|strtok_r|strerror_r|strsep|strchrnul|memmem|mempcpy|reallocarray|getline|getdelim|fileno|fdopen"
    r"|flockfile|funlockfile|open_memstream|fmemopen|dprintf|asprintf|vasprintf|popen)\()")


def sources(root, more=()):
    """Every source below FOLDERS and `more`, as a path from the root."""
    tops = {folder.split("/")[0] for folder in FOLDERS}.union(more)
    return sorted(str(path.relative_to(root)) for top in tops
                  for path in (root / top).rglob("*") if path.suffix in SOURCES)


def includes(root, files):
    """(file, included file, whether by its path from the root) for each include of a source of the
    project. What is generated at build time is none."""
    known = set(files)
    for file in files:
        for name in INCLUDE.findall((root / file).read_text(encoding="utf-8")):
            beside = os.path.normpath(os.path.join(os.path.dirname(file), name))
            if name in known:
                yield file, name, True
            elif beside in known:
                yield file, beside, False


def system_parts(root, file):
    """What a file has of a system: the names of headers, functions and macros."""
    text = (root / file).read_text(encoding="utf-8")
    for name in SYSTEM_INCLUDE.findall(text):
        if name.removesuffix(".h") not in PLAIN_HEADERS and not name.startswith(PLAIN_FOLDERS):
            yield f"<{name}>"
    for name in SYSTEM_CALL.findall(text):
        yield f"{name})"
    for found in SYSTEM_MACRO.findall(text):
        yield "".join(found)


def reached_headers(root, file, reached):
    """The system's headers that a file includes, also by the project's files."""
    if file in reached:
        return reached[file]
    reached[file] = found = set()
    text = (root / file).read_text(encoding="utf-8")
    found.update(SYSTEM_INCLUDE.findall(text))
    for name in INCLUDE.findall(text):
        beside = os.path.join(os.path.dirname(file), name)
        for path in (name, beside):
            if (root / path).is_file():
                found |= reached_headers(root, path, reached)
    return found


def lacking(root):
    """(source, word, header) for each word of PRECOMPILED whose headers a source does not include."""
    reached = {}
    for file in sources(root, ("tests", "scripts/tools")):
        text = COMMENT_OR_STRING.sub("", (root / file).read_text(encoding="utf-8"))
        headers = reached_headers(root, file, reached)
        for words, needed in PRECOMPILED:
            word = words.search(text)
            if word and not any(name.startswith(needed) for name in headers):
                yield file, word[0], needed[0]


def rank(file):
    """The height of a file's folder in FOLDERS, or None."""
    folder = os.path.dirname(file)
    while folder and folder not in FOLDERS:
        folder = os.path.dirname(folder)
    return FOLDERS.index(folder) if folder else None


def circles(edges):
    """The groups of modules that include each other (Tarjan's strongly connected components)."""
    graph = collections.defaultdict(set)
    for file, included in edges:
        a, b = os.path.splitext(file)[0], os.path.splitext(included)[0]
        if a != b:
            graph[a].add(b)
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for after in sorted(graph.get(node, ())):
            if after not in index:
                visit(after)
                low[node] = min(low[node], low[after])
            elif after in stack:
                low[node] = min(low[node], index[after])
        if low[node] == index[node]:
            group = stack[stack.index(node):]
            del stack[stack.index(node):]
            if len(group) > 1:
                found.append(sorted(group))

    sys.setrecursionlimit(10000)
    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(found)


def offenders(root):
    files = sources(root)
    counts = collections.Counter(os.path.dirname(file) for file in files)
    for folder, count in sorted(counts.items()):
        if count > FILES_MAX:
            yield f"{folder}: {count} files; at most {FILES_MAX}"
    for file in files:
        folder, name = os.path.split(file)
        if name.startswith(os.path.basename(folder) + "_"):
            yield f"{file}: the name repeats the folder's"
        if not file.startswith((PLATFORM + "/", PROGRAM + "/")):
            for part in system_parts(root, file):
                yield f"{file}: {part} belongs to a system: only {PLATFORM}/ has such parts"
    for file, word, header in lacking(root):
        yield f"{file}: {word} without an include of <{header}...>"
    edges = []
    for file, included, is_from_root in includes(root, files):
        edges.append((file, included))
        if not is_from_root:
            yield f"{file}: include {included} by its path from the repository's root"
        above, below = rank(file), rank(included)
        if above is None or below is None:
            yield f"{file}: includes {included}, and one of the two is in no folder of FOLDERS"
        elif below > above:
            yield f"{file}: includes {included}, which is above it"
        for consumer in CONSUMERS:
            if fnmatch.fnmatch(included, consumer) and not fnmatch.fnmatch(file, consumer):
                yield f"{file}: includes {included}, which an option of CMake leaves out"
    for group in circles(edges):
        yield "circle: " + ", ".join(group)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=pathlib.Path.cwd(),
                        help="of the repository (default: the working directory)")
    found = list(offenders(parser.parse_args().root.resolve()))
    print("\n".join(found) or "includes: all point down, none in a circle")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
