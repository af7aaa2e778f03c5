#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/accuracy/ of what the programs of scripts/accuracy wrote: tables as CSV, and the page
that shows and explains them. The pictures are gnuplot's (scripts/tools/accuracy/*.gp), from the same CSV."""

import argparse
import collections
import csv
import importlib.machinery
import importlib.util
import pathlib
import platform
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
LEVELS = ("parameters", "state", "execution", "content")
COMPARE = "content + compare"
RECORD = "execution + record"
SCENES = {"small": "1,000 small meshes", "mesh": "one mesh", "instances": "100,000 instances"}
ACCURACIES = ("fast", "robust", "exact")


def fail(message):
    sys.exit(f"page.py: {message}")


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return rows or fail(f"{path} is empty")


def write(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def load_coverage():
    """scripts/coverage, which reads the tables of rules."""
    loader = importlib.machinery.SourceFileLoader("coverage", str(ROOT / "scripts/coverage"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("coverage", loader))
    loader.exec_module(module)
    return module


# ---- the corpus

def play_corpus(raw, level):
    """The outcomes of each play at a level: {(program, case, command): {fired, unseen, silent, failed}}."""
    plays = collections.defaultdict(set)
    for program in ("calls", "execution"):
        for line in (raw / f"{program}-{level}.tsv").read_text().splitlines():
            _, case, command, _, outcome = line.split("\t")
            plays[program, case.removesuffix("@" + level), command].add(outcome)
    return plays


def judge_corpus(raw):
    """By level: mistakes caught, mistakes planted, valid calls, false alarms. What isn't played at
    every level counts at none."""
    by_level = {level: play_corpus(raw, level) for level in LEVELS}
    common = set.intersection(*(set(plays) for plays in by_level.values()))
    mistakes = {play for play in common for plays in by_level.values()
                if plays[play] & {"fired", "unseen"}}
    valid = {play for play in common for plays in by_level.values() if "silent" in plays[play]}
    return {level: {
        "mistakes": len(mistakes),
        "caught": sum("fired" in plays[play] and "failed" not in plays[play] for play in mistakes),
        "valid": len(valid),
        "false_alarms": sum("failed" in plays[play] for play in common)}
            for level, plays in by_level.items()}


# ---- checks

def find_cost(costs, *place):
    for row in costs:
        if (row["driver"], row["scene"], row["by"], row["level"]) == place:
            return row
    return None


def costs_of(costs, level, scene, by):
    """What compares needs a driver that traces rays, and has it work."""
    if level != COMPARE or by == "host":
        cost = find_cost(costs, "null", scene, by, level)
    elif cost := find_cost(costs, "lavapipe", scene, by, level):
        cost = {**cost, "added_ns": cost["added_all_threads_ns"]}
    return cost or fail(f"level {level}, {scene}, by the {by}: no cost")


def record_cost(costs):
    """What setting record_builds costs a small mesh, beside what its level costs."""
    return float(find_cost(costs, "null", SCENES["small"], "device", RECORD)["added_ns"])


def can_compare(costs):
    """Whether this build of the layer compares rays: a thousand take a millisecond at least."""
    content, compare = (find_cost(costs, "lavapipe", SCENES["mesh"], "device", level)
                        for level in (LEVELS[-1], COMPARE))
    return compare is not None and float(compare["added_ns"]) > float(content["added_ns"]) + 1e6


def make_checks(raw, dump, costs):
    ids = load_coverage().read_tables(dump)
    judged = judge_corpus(raw)
    levels = list(LEVELS) + [COMPARE] * can_compare(costs)
    rows = []
    for level in levels:
        own = level if level in LEVELS else LEVELS[-1]
        seen = LEVELS[:LEVELS.index(own) + 1]
        row = {"level": level,
               "ids": sum(not one.waits_for and one.level in seen for one in ids.values()),
               **judged[own]}
        row["caught_percent"] = f"{100 * row['caught'] / row['mistakes']:.1f}"
        for by in ("device", "host"):
            for key, scene in SCENES.items():
                cost = costs_of(costs, level, scene, by)
                row[f"{by}_{key}_ns"] = cost["added_ns"]
                row[f"{by}_{key}_bytes"] = cost["added_bytes"]
        rows.append(row)
    return rows


# ---- fronts

def mark_front(rows, costs):
    """Adds a column: no other row is better in one of these figures and as good in the others."""
    points = [[float(row[cost]) for cost in costs] for row in rows]
    for row, point in zip(rows, points):
        row["front"] = int(not any(other != point and all(a <= b for a, b in zip(other, point))
                                   for other in points))


def mark_fronts(rows, keys, costs):
    """The same for each group of rows that have the same keys."""
    groups = collections.defaultdict(list)
    for row in rows:
        groups[tuple(row[key] for key in keys)].append(row)
    for group in groups.values():
        mark_front(group, costs)
    return rows


def make_builder(rows):
    for row in rows:
        row["ns_a_primitive"] = f"{1e3 / float(row['mprims_a_second']):.1f}"
    return mark_fronts(rows, ("mesh", "builder"), ("ns_a_primitive", "sah"))


def make_effects(rows):
    for row in rows:
        never = int(row["never"])
        for use in ("unused", "used"):
            row[f"{use}_percent"] = f"{100 * (int(row[use]) / never - 1):.2f}"
    return rows


# ---- frames beside the Khronos layer

FRAMES = ROOT / "docs/accuracy/frames.csv"  # of scripts/bench content --peer, in Debian testing
SIDES = {"none": "no layer", "execution": "level execution", "content": "level content",
         "khronos": "Khronos layer", "khronos GPU-AV": "its GPU-assisted mode"}


def frames_table():
    times = {(row["scene"], row["side"]): row for row in read(FRAMES)}
    scenes = dict.fromkeys(scene for scene, _ in times)
    return table(("a frame builds", *SIDES.values()),
                 [(scene, *(f"{rounded(cell['wall_ms'])} / {rounded(cell['cpu_ms'])}"
                            for cell in (times[scene, side] for side in SIDES)))
                  for scene in scenes])


# ---- the page

def rounded(milliseconds):
    value = float(milliseconds)
    return f"{value:.2f}" if value < 10 else f"{value:.1f}" if value < 100 else f"{value:,.0f}"


def number(text, digits=0):
    return f"{float(text):,.{digits}f}"


def duration(nanoseconds):
    value = float(nanoseconds)
    for unit, size in (("ms", 1e6), ("µs", 1e3)):
        if abs(value) >= 10 * size or (unit == "ms" and abs(value) >= size):
            return f"{value / size:.{1 if abs(value) < 100 * size else 0}f} {unit}"
    return f"{value:,.0f} ns"


def table(heads, lines):
    text = ["| " + " | ".join(heads) + " |", "| --- |" + " --- |" * (len(heads) - 1)]
    text += ["| " + " | ".join(str(cell) for cell in line) + " |" for line in lines]
    return "\n".join(text)


def checks_table(rows):
    return table(
        ("level", "ids decided", "mistakes caught", "false alarms",
         "a small mesh", "a large mesh", "100,000 instances", "bytes a small mesh"),
        [(row["level"], row["ids"],
          f"{row['caught']:,} of {row['mistakes']:,} ({row['caught_percent']} %)",
          f"{row['false_alarms']} of {row['valid']:,}",
          *(duration(row[f"device_{key}_ns"]) for key in SCENES),
          number(row["device_small_bytes"])) for row in rows])


def host_table(rows):
    return table(
        ("level", "a small mesh", "a large mesh", "100,000 instances"),
        [(row["level"], *(duration(row[f"host_{key}_ns"]) for key in SCENES))
         for row in rows if row["level"] != COMPARE])


def rays_table(rows):
    balanced = {(row["rays"], row["accuracy"]): row for row in rows
                if row["quality"] == "balanced"}
    sets = list(dict.fromkeys(row["rays"] for row in rows))
    return table(
        ("rays", *(f"{accuracy}: ns a ray, wrong in a million" for accuracy in ACCURACIES)),
        [(name, *(f"{number(row['ns_a_ray'])}, {number(row['wrong_in_a_million'])} "
                  f"(nearest: {number(row['nearest_wrong_in_a_million'])})"
                  for row in (balanced[name, accuracy] for accuracy in ACCURACIES)))
         for name in sets])


def builder_table(rows):
    return table(
        ("mesh", "builder", "quality", "million primitives a second", "SAH cost", "ns a ray"),
        [(row["mesh"], row["builder"], row["quality"], number(row["mprims_a_second"], 2),
          number(row["sah"], 2), number(row["ns_a_ray"])) for row in rows])


def effects_table(rows):
    return table(
        ("effect", "without it: never seen", "without it: could be used", "with it"),
        [(row["effect"], number(row["never"]),
          f"{number(row['unused'])} ({float(row['unused_percent']):+.2f} %)",
          f"{number(row['used'])} ({float(row['used_percent']):+.0f} %)") for row in rows])


def plain_table(rows):
    return table(
        ("2,000 rays, or a build of 4,800 triangles", "before", "now"),
        [(row["what"], number(row["before"]),
          f"{number(row['now'])} ({100 * (int(row['now']) / int(row['before']) - 1):+.1f} %)")
         for row in rows])


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def update_readme(path, rows):
    """The table between two comments."""
    first, last = "<!-- scripts/accuracy writes this table -->\n", "<!-- end -->\n"
    text = path.read_text(encoding="utf-8")
    before, found, rest = text.partition(first)
    _, closed, after = rest.partition(last)
    if not found or not closed:
        fail(f"{path} has no place for the table")
    short = table(("level", "ids decided", "mistakes caught", "false alarms",
                   "CPU time added to a build"),
                  [(row["level"], row["ids"], f"{row['caught_percent']} %", row["false_alarms"],
                    duration(row["device_small_ns"])) for row in rows])
    path.write_text(before + first + short + "\n" + last + after, encoding="utf-8")


def make_page(tables, template):
    text = template
    for name, value in tables.items():
        text = text.replace("@" + name + "@", str(value))
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--raw", type=pathlib.Path, required=True, help="what the programs wrote")
    parser.add_argument("--dump", type=pathlib.Path, required=True, help="the program vuid_dump")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="docs/accuracy")
    parser.add_argument("--readme", type=pathlib.Path, help="whose table is written anew")
    parser.add_argument("--seconds", default="?", help="how long it took to measure")
    arguments = parser.parse_args()

    raw = arguments.raw
    costs = [row for driver in ("null", "lavapipe")
             if (raw / f"costs-{driver}.csv").exists() for row in read(raw / f"costs-{driver}.csv")]
    checks = make_checks(raw, arguments.dump, costs)
    rays = mark_fronts(read(raw / "rays.csv"), ("rays",), ("ns_a_ray", "wrong_in_a_million"))
    builder = make_builder(read(raw / "builder.csv")) if (raw / "builder.csv").exists() else []
    effects = make_effects(read(raw / "effects.csv"))
    plain = read(raw / "plain.csv") if (raw / "plain.csv").exists() else []
    arguments.output.mkdir(parents=True, exist_ok=True)
    for name, rows in (("checks", checks), ("costs", costs), ("rays", rays), ("builder", builder),
                       ("effects", effects), ("plain", plain)):
        if rows:
            write(arguments.output / f"{name}.csv", rows)

    template = (pathlib.Path(__file__).parent / "page.md").read_text(encoding="utf-8")
    page = make_page({"CHECKS": checks_table(checks), "HOST": host_table(checks),
                      "FRAMES": frames_table(),
                      "RECORD": duration(record_cost(costs)),
                      "MISTAKES": f"{checks[0]['mistakes']:,}", "VALID": f"{checks[0]['valid']:,}",
                      "RAYS": rays_table(rays), "TRACED": number(rays[0]["traced"]),
                      "BUILDER": builder_table(builder), "EFFECTS": effects_table(effects),
                      "PLAIN": plain_table(plain), "PROCESSOR": processor(), "SECONDS": arguments.seconds}, template)
    (arguments.output / "README.md").write_text(page, encoding="utf-8")
    if arguments.readme:
        update_readme(arguments.readme, checks)
    alarms = sum(row["false_alarms"] for row in checks)
    if alarms:
        fail(f"{alarms} false alarms: see what programs_test says at each level")


if __name__ == "__main__":
    main()
