# SPDX-License-Identifier: Apache-2.0
"""Tests of the text that generate.py makes of the registry's HTML."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "vuid-tables"))
from plain_text import plain_text  # noqa: E402


class PlainText(unittest.TestCase):
    def check(self, html, expected):
        self.assertEqual(plain_text(html), expected)

    def test_tags_vanish(self):
        self.check('<code>a</code>[i] <strong class="purple">must</strong> be <a href="#x">b</a>',
                   "a[i] must be b")

    def test_comparisons_stay(self):
        self.check("<code>a</code> &lt; b &amp;&amp; c &gt; d", "a < b && c > d")

    def test_arrows_and_quotes_are_ascii(self):
        self.check("the micromap&#8217;s <code>p</code>[i]&#8594;count × 2", "the micromap's "
                   "p[i]->count x 2")

    def test_powers(self):
        self.check('<span class="eq">2<sup>32</sup>-1</span>', "2^32-1")

    def test_white_space_folds(self):
        self.check(" a\n  b \u00a0c ", "a b c")

    def test_lists_read_as_one_sentence(self):
        item = "<li>\n<p>{}</p>\n</li>\n"
        html = ('of:<div class="ulist">\n<ul>\n' + item.format("the <em>size</em>,\nor") +
                item.format("half of it,") + item.format("none") + "</ul>\n</div>")
        self.check(html, "of: the size, or; half of it, none")

    def test_plus_that_the_converter_lost(self):
        self.check('<span class="eq">[<code>o</code>, <code>o</code><br> size]</span><br>end',
                   "[o, o + size] end")

    def test_nothing(self):
        self.check("", "")


if __name__ == "__main__":
    unittest.main()
