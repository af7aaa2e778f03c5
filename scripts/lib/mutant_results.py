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


def change_of(root, mutation):
    """The first line that a mutation changes, before and after."""
    lines = diff_of(root, mutation).splitlines()[3:]
    return tuple(next((line[1:].strip() for line in lines if line[0] == sign), "") for sign in "-+")


def read_explained(path):
    """The kind and the reason of mutants that survive, by source, line and mutated line. The file
    explains itself."""
    reasons = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            name, before, after, kind, reason = line.split("\t")
            reasons[name, before, after] = kind, reason
    return reasons


def digest_of(root, tests):
    """Of all that a result depends on: scripts and pages are not part of it."""
    digest = hashlib.sha256(tests.encode())
    for name in repository_files(root):
        if not name.startswith(("scripts/", "docs/", ".")) and not name.endswith(".md"):
            digest.update(name.encode() + b"\0" + (root / name).read_bytes() + b"\0")
    return digest.hexdigest()


def key_of(mutation):
    return f"{mutation.path}:{mutation.begin}:{mutation.end}:{mutation.text}"


class Results:
    """May be used by several threads."""

    def __init__(self, root, tests=""):
        self.path = root / "build" / "mutants" / "results.jsonl"
        self.lock = threading.Lock()
        self.outcomes = {}
        self.killers = {}  # of mutations; those of older sources and tests stay
        self.kills = {}    # of each folder, by test
        self.digest = digest_of(root, tests)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.read(self.path.read_text().splitlines() if self.path.exists() else [])
        records = ({"digest": self.digest, "killers": self.killers}, *self.outcomes.values())
        fresh = self.path.with_suffix(".new")
        fresh.write_text("".join(json.dumps(record) + "\n" for record in records))
        fresh.replace(self.path)

    def read(self, lines):
        digest = None
        for line in lines:
            try:
                record = json.loads(line)
            except ValueError:
                continue  # the run ended while it was written
            if "digest" in record:
                digest = record["digest"]
                for mutation, killer in record.get("killers", {}).items():
                    self.note({"mutation": mutation, "outcome": "killed", "killer": killer})
                self.outcomes = {}
            else:
                self.note(record)
        if digest != self.digest:
            self.outcomes = {}
        if self.outcomes:
            print(f"mutants: {len(self.outcomes)} results of before in {self.path}")

    def note(self, record):
        mutation = record["mutation"]
        self.outcomes[mutation] = record
        if record["outcome"] == "killed" and self.killers.get(mutation) != record["killer"]:
            self.killers[mutation] = record["killer"]
            folder = os.path.dirname(mutation.split(":")[0])
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

    def kills_of(self, test, mutation):
        """Whether a test has killed the mutation before, and how many of the same folder and of all."""
        folder = os.path.dirname(mutation.path)
        with self.lock:
            return (self.killers.get(key_of(mutation)) == test,
                    self.kills.get(folder, {}).get(test, 0),
                    sum(counter.get(test, 0) for counter in self.kills.values()))
