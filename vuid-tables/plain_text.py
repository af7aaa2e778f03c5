# SPDX-License-Identifier: Apache-2.0
"""The registry's HTML sentences as plain text."""

import html.parser
import re

# What a terminal without fonts for it should still show.
ASCII = str.maketrans({
    "\u2018": "'", "\u2019": "'", "\u201c": '"', "\u201d": '"', "\u2013": "-", "\u2192": "->",
    "\u00d7": "x", "\u2264": "<=", "\u2265": ">=", "\u2026": "...", "\u200b": "", "\u00a0": " ",
})


class Reader(html.parser.HTMLParser):
    """Collects text; lists become `; ` between items, sup becomes ^."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.text = ""
        self.equations = 0  # spans of class eq that are open, and spans inside them
        self.lists = []  # a list that is open: its items so far

    def handle_starttag(self, tag, attrs):
        if tag == "span" and (self.equations or dict(attrs).get("class") == "eq"):
            self.equations += 1
        elif tag == "br":
            # The sources write a sum over two lines as "a +" and "b"; the converter takes the
            # trailing plus for a line break.
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
    """One line without markup: "<code>a</code> &#8594; 2<sup>32</sup>" gives "a -> 2^32"."""
    reader = Reader()
    reader.feed(sentence)
    reader.close()
    return re.sub(r"\s+", " ", reader.text.translate(ASCII)).strip()
