# SPDX-License-Identifier: Apache-2.0
"""Links of the documents lead somewhere, and their shell lines name programs, options and settings that exist. They name
each id of the layer's own; warnings.md has a section for each warning, and unknown.md a line for each thing that can
become unknown."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
ID = re.compile(r'"(ASSAY-[a-z-]+)"')
PLAIN = {"ASSAY-error", "ASSAY-warning", "ASSAY-info"}  # of all lines without an id of their own
SCENE = None  # the program assay-scene, if the build has it


def anchors_of(text):
    """The anchors that GitHub makes of headings."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()).replace(" ", "-")
            for heading in headings}


def shell_blocks(text):
    return re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S)


def shell_lines():
    """Each command of the blocks of shell, and of such words in sentences, as (page, words), without comments and what a -- introduces."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in shell_blocks(text) + re.findall(r"`((?:scripts/|assay-run |assay-scene )[^`]*)`", text):
            for line in re.sub(r"\\\n", " ", block).splitlines():
                for command in re.split(r"&&|\||;", re.sub(r"(^|\s)#.*", "", line)):
                    words = re.sub(r"\s--(\s.*)?$", "", command).split()
                    while words and re.match(r"\w+=", words[0]):
                        words = words[1:]
                    if words:
                        yield page.relative_to(ROOT), words


def options_of(words):
    return [word.split("=")[0] for word in words if word.startswith("--") and word != "--"]


def help_of(program, *words):
    run = subprocess.run([program, *words, "--help"], stdout=subprocess.PIPE, check=True, text=True,
                         env=dict(os.environ, COLUMNS="200"))
    return run.stdout


class Documents(unittest.TestCase):
    def test_links_lead_somewhere(self):
        for page in PAGES:
            for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
                if re.match(r"[a-z]+:", link):
                    continue
                path, _, anchor = link.partition("#")
                target = page.parent / path if path else page
                with self.subTest(page=str(page.relative_to(ROOT)), link=link):
                    self.assertTrue(target.exists())
                    if anchor:
                        self.assertIn(anchor, anchors_of(target.read_text(encoding="utf-8")))

    def check_options(self, page, words, text):
        for option in options_of(words):
            with self.subTest(page=str(page), line=" ".join(words), option=option):
                self.assertTrue(re.search(re.escape(option) + r"(?![\w-])", text))

    def test_scripts_have_the_options(self):
        texts, count = {}, 0
        for page, words in shell_lines():
            name = "scripts/assay-run" if words[0] == "assay-run" else words[0]
            if not re.fullmatch(r"scripts/[\w-]+", name) or name == "scripts/lib":
                continue
            count += 1
            with self.subTest(page=str(page), script=name):
                self.assertTrue((ROOT / name).is_file())
            if name not in texts:
                texts[name] = help_of(ROOT / name)
                if name == "scripts/bench":  # its programs have the other options
                    texts[name] += "".join(path.read_text(encoding="utf-8")
                                           for path in (ROOT / "scripts/tools").glob("*/*.[cp]*"))
            self.check_options(page, words, texts[name])
        self.assertGreater(count, 20)

    def test_assay_scene_has_the_options(self):
        if not SCENE:
            self.skipTest("the build has no assay-scene")
        text, count = help_of(SCENE), 0
        for page, words in shell_lines():
            if words[0] == "assay-scene":
                count += 1
                with self.subTest(page=str(page), line=" ".join(words)):
                    self.assertTrue(words[1] in text)
                self.check_options(page, words, text)
        self.assertGreater(count, 10)

    def test_manuals_render(self):
        if not shutil.which("groff"):
            self.skipTest("groff is missing")
        settings = subprocess.run([sys.executable, "-B", ROOT / "scripts/lib/tables.py", ROOT, "--print", "manual"],
                                  stdout=subprocess.PIPE, check=True, text=True).stdout
        for page in sorted((ROOT / "docs/man").iterdir()):
            with self.subTest(page=page.name):
                text = page.read_text(encoding="utf-8").replace("@ASSAY_SETTINGS_MANUAL@\n", settings)
                run = subprocess.run(["groff", "-man", "-ww", "-Kutf8", "-Tutf8"], input=text, text=True, check=True,
                                     capture_output=True)
                self.assertEqual(run.stderr, "")

    def test_settings_exist(self):
        names = set(re.findall(r"^(?:SETTING|[A-Z_]+)\((\w+),",
                               (ROOT / "src/report/settings.def").read_text(encoding="utf-8"), re.M))
        self.assertIn("hazards", names)
        for page, words in shell_lines():
            for setting in re.findall(r"--set[ =](\w+)=|VK_ASSAY_VALIDATION_(\w+)=", " ".join(words)):
                with self.subTest(page=str(page), setting=setting):
                    self.assertIn((setting[0] or setting[1]).lower(), names)

    def test_presets_and_targets_exist(self):
        presets = (ROOT / "CMakePresets.json").read_text(encoding="utf-8")
        for page, words in shell_lines():
            if words[0] == "cmake":
                for preset in re.findall(r"--preset (\w+)", " ".join(words)):
                    with self.subTest(page=str(page), preset=preset):
                        self.assertIn(f'"name": "{preset}"', presets)


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
    SCENE = sys.argv.pop(1) if len(sys.argv) > 1 else None
    unittest.main()
