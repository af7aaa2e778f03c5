# SPDX-License-Identifier: Apache-2.0
"""Converts the registry's HTML sentences to plain text."""

import html.parser
import re

# ASCII replacements, so that every terminal can show the sentences.
ASCII = str.maketrans({
    "\u2018": "'", "\u2019": "'", "\u201c": '"', "\u201d": '"', "\u2013": "-", "\u2192": "->",
    "\u00d7": "x", "\u2264": "<=", "\u2265": ">=", "\u2026": "...", "\u200b": "", "\u00a0": " ",
})


class Reader(html.parser.HTMLParser):
    """Collects text; lists become `; ` between items, sup becomes ^."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.text = ""
        self.equations = 0  # open spans of class eq, and open spans inside them
        self.lists = []  # for each open list: the number of its items so far

    def handle_starttag(self, tag, attrs):
        if tag == "span" and (self.equations or dict(attrs).get("class") == "eq"):
            self.equations += 1
        elif tag == "br":
            # The specification's sources split a sum into the lines "a +" and "b"; the HTML
            # converter turns the trailing plus into a line break.
            self.text += " + " if self.equations else " "
        elif tag == "sup":
            self.text += "^"
        elif tag in ("ul", "ol"):
            self.lists.append(0)
            self.text = self.text.rstrip() + " "
        elif tag == "li" and self.lists:
            if self.lists[-1]:
                self.text = self.text.rstrip()
                self.text += " " if self.text.endswith((",", ";")) else "; "
            self.lists[-1] += 1
        elif tag in ("p", "div"):
            self.text += " "

    def handle_endtag(self, tag):
        if tag == "span" and self.equations:
            self.equations -= 1
        elif tag in ("ul", "ol") and self.lists:
            self.lists.pop()
            self.text += " "
        elif tag in ("p", "div"):
            self.text += " "

    def handle_data(self, data):
        self.text += data


def plain_text(sentence):
    """Returns one line without markup: "<code>a</code> &#8594; 2<sup>32</sup>" becomes
    "a -> 2^32"."""
    reader = Reader()
    reader.feed(sentence)
    reader.close()
    return re.sub(r"\s+", " ", reader.text.translate(ASCII)).strip()
