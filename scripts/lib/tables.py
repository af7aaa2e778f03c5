#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what other files say of the rows of src/report/properties.def and settings.def, or checks it: the
properties of findings in json/findings.schema.json, and the table of settings in docs/settings.md; the same for
folders: what the README of each says of includes, and the table in docs/contributing.md. Fails if a file
differs; with --write it is rewritten. With --print, prints what the build needs of the settings."""

import argparse
import json
import pathlib
import re
import sys

COMMENT = re.compile(r"/\*.*?\*/", re.S)
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|.', re.S)


def read_rows(path):
    """Yields each row of a table as (macro, arguments); strings of C are joined."""
    text = COMMENT.sub("", path.read_text(encoding="utf-8"))
    text = re.sub(r"^#.*$", "", text, flags=re.M)
    for start in re.finditer(r"^([A-Z_]+)\(", text, re.M):
        arguments, depth = [""], 1
        for token in TOKEN.finditer(text, start.end()):
            depth += (token[0] == "(") - (token[0] == ")")
            if not depth:
                break
            if token[0] == "," and depth == 1:
                arguments.append("")
            else:
                arguments[-1] += token[0]
        yield start[1], [join_strings(argument.strip()) for argument in arguments]


def join_strings(argument):
    parts = re.findall(r'"(?:\\.|[^"\\])*"', argument)
    if not parts or re.sub(r'"(?:\\.|[^"\\])*"|\s', "", argument):
        return argument
    return "".join(map(json.loads, parts))


# ---- properties of findings

def schema_of(kind, about, span=""):
    schema = {"description": about} if about else {}
    if span:
        schema["$comment"] = f"several findings: {span}"
    return schema | ({"type": "string"} if kind == "text" else {"$ref": f"#/$defs/{kind}"})


def finding_schemas(root):
    """Returns the schemas of the properties by key, the keys that each finding has, and those with a range."""
    schemas, required, ranged = {}, [], []
    for macro, row in read_rows(root / "src/report/properties.def"):
        if macro == "LABELS" or row[0] == "NULL":
            continue
        span = row[6] if macro == "PLACE" else ""
        schemas[row[0]] = schema_of(row[1], row[-1], span)
        required += [row[0]] if row[2] == "true" else []
        ranged += [row[0]] if span else []
    return schemas, required, ranged


def member_lines(schemas):
    return "".join(f'        "{key}": {{ {json.dumps(schema)[1:-1]} }},\n' for key, schema in schemas.items())


def write_schema(root, text):
    schemas, required, ranged = finding_schemas(root)
    begin = text.index('        "Severity": ')
    end = text.index('        "pid": true', begin)
    text = text[:begin] + member_lines(schemas) + text[end:]
    required_at = text.index('"required": [', begin) + len('"required": ')
    text = text[:required_at] + json.dumps(required) + text[text.index("]", required_at) + 1:]
    records = member_lines({key: {"$ref": f"#/$defs/finding/properties/{key}"} for key in ranged})
    return re.sub(r'(        "\w+": \{ "\$ref": "#/\$defs/finding/properties/\w+" \},\n)+', lambda _: records, text)


# ---- settings

KINDS = {"CHOICE": "ENUM", "CHOICE_OF": "ENUM", "FLAGS": "FLAGS", "SWITCH": "BOOL", "NUMBER": "INT"}
BOOLEANS = {"true": True, "false": False}


class Setting:
    def __init__(self, macro, row):
        self.key, self.label, self.says = row[0], row[-2], row[-1]
        self.kind = KINDS.get(macro) or row[1]
        self.default = row[2] if macro in ("CHOICE_OF", "OWN") else row[1]
        self.most = row[2] if macro == "NUMBER" and row[2].isdecimal() else None
        self.accepts = row[3] if macro in ("NUMBER", "OWN") else ""
        self.values = []     # (name, label, says)
        self.parent = None   # (key, value)

    @property
    def words(self):
        return [name for name, _, _ in self.values] or (list(BOOLEANS) if self.kind == "BOOL" else [])


def read_settings(root):
    """Returns the settings by key, and what each preset sets, by its name."""
    settings, presets, names, made = {}, {}, {}, {}
    for macro, row in read_rows(root / "src/report/settings.def"):
        if macro in KINDS or macro == "OWN":
            settings[row[0]] = Setting(macro, row)
        elif macro in ("VALUE", "GIVEN"):
            settings[row[0]].values.append(tuple(row[2:]))
            names[row[1]] = row[2]
        elif macro == "NEEDS":
            settings[row[0]].says += f" Needs {row[2].rsplit('. ', 1)[0]}."
        elif macro == "UNDER":
            settings[row[0]].parent = row[1:]
        elif macro == "PRESET":
            made[row[1]] = row[2]
            presets[names[row[0]]] = dict(made)
    return settings, presets


def plain(says):
    """Returns a text of docs/settings.md without Markdown."""
    return re.sub(r" \(\[[^]]*\]\([^)]*\)[^)]*\)", "", says).replace("`", "")


def value_of(setting, text):
    """Returns a value as the manifest has it."""
    if setting.kind in ("LIST", "FLAGS"):
        return [] if text == "none" else text.split(",")
    return BOOLEANS[text] if setting.kind == "BOOL" else int(text) if setting.kind == "INT" else text


def feature(setting, settings):
    made = {"key": setting.key, "env": f"VK_ASSAY_VALIDATION_{setting.key.upper()}", "label": setting.label,
            "description": plain(setting.says), "type": setting.kind}
    if setting.key == "preset":
        made["view"] = "HIDDEN"  # Vulkan Configurator gives all settings, and has presets of its own
    if setting.values:
        made["flags"] = [{"key": name, "label": label, "description": plain(says)} for name, label, says in setting.values]
    if setting.kind == "INT":
        made["range"] = {"min": 0} | ({"max": int(setting.most)} if setting.most else {})
    if setting.kind == "LIST":
        made["list"] = []
    if setting.kind == "SAVE_FILE":
        made["filter"] = "*.txt"
    made["default"] = value_of(setting, setting.default)
    if setting.parent:
        key, value = setting.parent
        made["dependence"] = {"mode": "ALL", "settings": [{"key": key, "value": value_of(settings[key], value)}]}
    children = [feature(one, settings) for one in settings.values() if one.parent and one.parent[0] == setting.key]
    return made | ({"settings": children} if children else {})


def features(root):
    """Returns the manifest's list of settings. Its presets have no record of builds, which needs a log as JSON."""
    settings, presets = read_settings(root)
    shown = [("Parameters only", "The cheapest checks: only the parameters of each build command.",
              {"level": "parameters"})]
    shown += [(label, plain(says), presets[name]) for name, label, says in settings["preset"].values if name in presets]
    return {"presets": [{"label": label, "description": says,
                         "settings": [{"key": key, "value": value_of(settings[key], value)}
                                      for key, value in chosen.items() if key != "record_builds"]}
                        for label, says, chosen in shown],
            "settings": [feature(one, settings) for one in settings.values() if not one.parent]}


def values_text(setting):
    listed = ", ".join(f"`{word}`" for word in setting.words)
    return {"FLAGS": f"list of {listed}", "INT": "a number", "LIST": "a list", "SAVE_FILE": "a file",
            "SAVE_FOLDER": "a folder", "STRING": "a text"}.get(setting.kind, listed)


def between(text, name, new):
    """Returns the text with `new` between the comments of that name."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    return text[:text.index(begin) + len(begin)] + new + text[text.index(end):]


def write_page(root, text):
    """Writes the table between the comments."""
    settings, _ = read_settings(root)
    rows = [f"| `{one.key}` | {values_text(one)} | `{one.default}` | " +
            " ".join([one.says, *(f"`{name}`: {says}" for name, _, says in one.values)]) + " |\n"
            for one in settings.values()]
    return between(text, "settings",
                   "| key | values | default | what it does |\n| --- | --- | --- | --- |\n" + "".join(rows))


def manual(root):
    """Returns the list of settings for the manual of assay-run."""
    settings, _ = read_settings(root)
    return "\n".join(f".TP\n.B {one.key}\n" + plain(one.says).replace("\\", "\\e").replace("-", "\\-") +
                     f" Default: {one.default}." for one in settings.values())


def completions(root):
    """Returns each setting with each of its words, as --set of assay-run takes them."""
    settings, _ = read_settings(root)
    return " ".join(f"{one.key}={word}" for one in settings.values() for word in one.words or [""]
                    if one.key not in ("log_filename", "log_format"))


# ---- all files

FILES = {"json/findings.schema.json": write_schema, "docs/settings.md": write_page}
PRINTED = {"features": lambda root: json.dumps(features(root), indent=2, ensure_ascii=False),
           "manual": manual, "completions": completions}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=pathlib.Path.cwd(),
                        help="of the repository (default: the working directory)")
    parser.add_argument("--write", action="store_true", help="write the files")
    parser.add_argument("--print", choices=PRINTED, help="for the manifest, the manual, or the completion")
    arguments = parser.parse_args()
    if arguments.print:
        print(PRINTED[arguments.print](arguments.root))
        return
    import folders  # pylint: disable=import-outside-toplevel # assay-run reads this file from elsewhere
    files, stale = {**FILES, **folders.FILES}, []
    for name, write in files.items():
        path = arguments.root / name
        text = path.read_text(encoding="utf-8")
        wanted = write(arguments.root, text)
        if wanted != text:
            stale.append(name)
        if wanted != text and arguments.write:
            path.write_text(wanted, encoding="utf-8")
    if stale and not arguments.write:
        print("\n".join(f"{name}: differs from the tables; scripts/lint --tables --fix rewrites it" for name in stale))
    elif not arguments.write:
        print(f"tables: {len(files)} files are up to date")
    sys.exit(1 if stale and not arguments.write else 0)


if __name__ == "__main__":
    main()
