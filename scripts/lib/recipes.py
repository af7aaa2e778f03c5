#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the shell lines of a recipe in docs/ci, for scripts/packages --recipes.

The steps that publish reports are those of the services, and are left out."""

import json
import pathlib
import re
import sys


def github_lines(text):
    import yaml
    recipe = yaml.safe_load(text)
    yield from assignments(recipe["env"])
    for step in recipe["jobs"]["assay"]["steps"]:
        if "run" in step:
            yield f"(set -e\n{step['run']})"  # each step is a shell of its own


def gitlab_lines(text):
    import yaml
    recipe = yaml.safe_load(text)
    yield from assignments(recipe["variables"])
    yield from recipe["assay"]["before_script"]
    yield from recipe["assay"]["script"]


def assignments(variables):
    """The caller's values win: where Assay comes from, and what to run."""
    for name, value in variables.items():
        yield f": \"${{{name}:={value}}}\"; export {name}"


def docker_lines(text, stage):
    """The lines of one stage. A stage may copy from the folder /context, which has the repository as
    `.`, and the files of the other stages by their names."""
    parts = re.split(r"^FROM .*$", text, flags=re.M)
    for line in parts[stage + 1].splitlines():
        word, _, rest = line.partition(" ")
        if word == "RUN":
            yield rest
        elif word == "WORKDIR":
            yield f"mkdir -p {rest}; cd {rest}"
        elif word == "COPY" and rest.startswith("--from="):
            _, source, target = rest.split()
            yield f"cp /context/{pathlib.Path(source).name} {target}"
        elif word == "COPY":
            source, target = rest.split()
            yield f"mkdir -p {target}; cp -r /context/{source}/. {target}"
        elif word == "ENTRYPOINT":
            yield "set -- " + " ".join(json.loads(rest))
            yield '"$@" -- $APPLICATION'


def main():
    path = pathlib.Path(sys.argv[1])
    text = path.read_text(encoding="utf-8")
    if path.name == "github.yml":
        lines = github_lines(text)
    elif path.name == "gitlab.yml":
        lines = gitlab_lines(text)
    else:
        lines = docker_lines(text, int(sys.argv[2]))
    print("\n".join(["set -e", *lines]))


if __name__ == "__main__":
    main()
