#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the files and functions that docs/architecture.md, contributing.md, commands.md, glossary.md and
threads.md name in backticks exist, and that a function stands in the file which the sentence gives for it.
Prints each that doesn't, and fails if there is one. A path may begin below any folder of the sources."""

import argparse
import pathlib
import re
import sys

PAGES = ("docs/architecture.md", "docs/contributing.md", "docs/code/commands.md", "docs/code/glossary.md",
         "docs/code/threads.md")
FOLDERS = ("layer", "src", "vuid-tables")
SUFFIXES = (".c", ".h", ".comp", ".def", ".py")
NOT_CHECKED = re.compile(r"build/.*|\w+/X")  # what a build makes, and what stands for many names


def path_exists(root, path):
    return (root / path).exists() or any(
        next((root / folder).rglob(path.rstrip("/")), None) for folder in (*FOLDERS, "tests", "scripts"))


def missing(root, page):
    text = page.read_text(encoding="utf-8")
    names = re.findall(r"`([^`\n]+)`", text)
    for path in sorted({name for name in names if re.fullmatch(r"[\w-]+(/[\w.-]*)+", name)}):
        if not NOT_CHECKED.fullmatch(path) and not path_exists(root, path):
            yield f"{page.name}: there is no {path}"
    sources = "\n".join(file.read_text(encoding="utf-8") for folder in FOLDERS
                        for file in (root / folder).rglob("*") if file.suffix in SUFFIXES)
    for function, path in sorted(set(re.findall(r"`(\w+)\(\)`\s+(?:in\s+)?\(?`([\w-]+(?:/[\w.-]+)+)`", text))):
        if (root / path).is_file() and f"{function}(" not in (root / path).read_text(encoding="utf-8"):
            yield f"{page.name}: {path} has no function {function}()"
    for function in sorted({name[:-2] for name in names if re.fullmatch(r"\w+\(\)", name)}):
        if not re.search(rf"^(?![ \t*/]).*\b{function}\(|^{function}\(", sources, re.M):
            yield f"{page.name}: there is no function {function}()"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=pathlib.Path.cwd(),
                        help="of the repository (default: the working directory)")
    root = parser.parse_args().root.resolve()
    found = [line for page in PAGES for line in missing(root, root / page)]
    print("\n".join(found) or f"names: all that {', '.join(PAGES)} name exist")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
