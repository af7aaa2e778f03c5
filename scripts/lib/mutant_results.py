# SPDX-License-Identifier: Apache-2.0
"""The results of the mutants, a line of build/mutants/results.jsonl each, so that an interrupted
run can go on. Also how a mutation is shown."""

import difflib
import hashlib
import json
import os
import threading
from collections import Counter

from mutant_copy import repository_files


def line_of(root, mutation):
    text = (root / mutation.path).read_text(encoding="utf-8")
    return text.count("\n", 0, mutation.begin) + 1


def mutated(text, mutation):
    return text[:mutation.begin] + mutation.text + text[mutation.end:]


def diff_of(root, mutation):
    text = (root / mutation.path).read_text(encoding="utf-8")
    lines = difflib.unified_diff(text.splitlines(True), mutated(text, mutation).splitlines(True),
                                 "a/" + mutation.path, "b/" + mutation.path, n=2)
    return "".join(lines)


def digest_of(root):
    """Of all that a result depends on: scripts and pages are not part of it."""
    digest = hashlib.sha256()
    for name in repository_files(root):
        if not name.startswith(("scripts/", "docs/", ".")) and not name.endswith(".md"):
            digest.update(name.encode() + b"\0" + (root / name).read_bytes() + b"\0")
    return digest.hexdigest()


def key_of(mutation):
    return f"{mutation.path}:{mutation.begin}:{mutation.end}:{mutation.text}"


class Results:
    """May be used by several threads."""

    def __init__(self, root):
        self.path = root / "build" / "mutants" / "results.jsonl"
        self.lock = threading.Lock()
        self.outcomes, self.kills = {}, {}  # kills: of each folder, by test
        digest = digest_of(root)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        lines = self.path.read_text().splitlines() if self.path.exists() else []
        if lines and lines[0] == json.dumps({"digest": digest}):
            for line in lines[1:]:
                try:
                    self.note(json.loads(line))
                except ValueError:
                    pass  # the run ended while it was written
            print(f"mutants: {len(self.outcomes)} results of before in {self.path}")
        records = ({"digest": digest}, *self.outcomes.values())
        fresh = self.path.with_suffix(".new")
        fresh.write_text("".join(json.dumps(record) + "\n" for record in records))
        fresh.replace(self.path)

    def note(self, record):
        self.outcomes[record["mutation"]] = record
        if record["outcome"] == "killed":
            folder = os.path.dirname(record["mutation"].split(":")[0])
            self.kills.setdefault(folder, Counter())[record["killer"]] += 1

    def find(self, mutation):
        with self.lock:
            return self.outcomes.get(key_of(mutation))

    def add(self, mutation, outcome):
        record = {"mutation": key_of(mutation), "kind": mutation.kind, **outcome}
        with self.lock:
            self.note(record)
            with self.path.open("a", encoding="utf-8") as output:
                output.write(json.dumps(record) + "\n")
        return record

    def kills_of(self, test, path):
        """How many mutants a test has killed: of the same folder, and of all."""
        with self.lock:
            same = self.kills.get(os.path.dirname(path), {}).get(test, 0)
            return same, sum(counter.get(test, 0) for counter in self.kills.values())
