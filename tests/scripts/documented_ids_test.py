# SPDX-License-Identifier: Apache-2.0
"""The documents name each id of the layer's own; warnings.md has a section for each warning, and unknown.md
a line for each thing that can become unknown."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ID = re.compile(r'"(ASSAY-[a-z-]+)"')
PLAIN = {"ASSAY-error", "ASSAY-warning", "ASSAY-info"}  # of all lines without an id of their own


def ids_of(*patterns):
    """Returns the ids that are string literals in these sources."""
    files = [path for pattern in patterns for path in ROOT.glob(pattern)]
    return {name for path in files for name in ID.findall(path.read_text(encoding="utf-8"))}


class DocumentedIds(unittest.TestCase):
    def test_each_id_is_named(self):
        text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs").rglob("*.md"))
        ids = ids_of("src/**/*.c", "layer/**/*.c", "vuid-tables/*.def") - PLAIN
        self.assertIn("ASSAY-crash", ids)
        self.assertEqual([name for name in sorted(ids) if not re.search(rf"{name}(?![a-z-])", text)], [])

    def test_each_warning_has_a_section(self):
        ids = ids_of("vuid-tables/warnings.def")
        text = (ROOT / "docs/warnings.md").read_text(encoding="utf-8")
        self.assertIn("ASSAY-read-past-buffer", ids)
        self.assertEqual(ids - set(re.findall(r"^## (\S+)$", text, re.MULTILINE)), set())

    def test_each_unknown_has_a_line(self):
        rows = re.findall(r'^UNKNOWN\(\w+, "(.+)"\)$', (ROOT / "src/base/unknown.def").read_text(encoding="utf-8"), re.M)
        text = (ROOT / "docs/unknown.md").read_text(encoding="utf-8")
        self.assertIn("query pools after memory ran out for one", rows)
        self.assertEqual(rows, re.findall(r"^\| (.+?) \|", text.split("| --- | --- | --- |")[1], re.MULTILINE))


if __name__ == "__main__":
    unittest.main()
