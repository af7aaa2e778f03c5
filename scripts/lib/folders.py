# SPDX-License-Identifier: Apache-2.0
"""What documents say of folders: the README of each, of includes, and the table in docs/contributing.md."""

import collections
import functools
import pathlib
import re

import includes
from tables import between

FOLDERS = [folder for folder in includes.FOLDERS if folder.count("/") < 2]


def folder_of(file):
    return next((folder for folder in map(str, pathlib.PurePath(file).parents) if folder in FOLDERS), None)


@functools.cache
def uses_of_folders(root):
    """Returns which folders each folder includes, and which include it."""
    uses, users = collections.defaultdict(set), collections.defaultdict(set)
    for file, included, _ in includes.includes(root, includes.sources(root)):
        a, b = folder_of(file), folder_of(included)
        if a != b:
            uses[a].add(b)
            users[b].add(a)
    return uses, users


def listed(folders):
    return ", ".join(f"`{folder}`" for folder in FOLDERS if folder in folders) or "none"


def write_readme(folder, root, text):
    uses, users = uses_of_folders(root)
    return between(text, "includes", f"It includes headers of: {listed(uses[folder])}.\n\n"
                                     f"It is included by: {listed(users[folder])}.\n")


def write_folders(root, text):
    """Writes the table of folders: the first paragraph of each README."""
    rows = ""
    for folder in FOLDERS:
        says = (root / folder / "README.md").read_text(encoding="utf-8").split("\n\n")[1].replace("\n", " ")
        says = re.sub(r"\]\((\.\./)+docs/", "](", says)
        rows += f"| [`{folder}/`](../{folder}) | {says} |\n"
    return between(text, "folders", "| folder | contents |\n| --- | --- |\n" + rows)


FILES = {**{f"{folder}/README.md": functools.partial(write_readme, folder) for folder in FOLDERS},
         "docs/contributing.md": write_folders}
