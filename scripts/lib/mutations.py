# SPDX-License-Identifier: Apache-2.0
"""Where C sources can be changed by one small mistake, and how: the mutations of scripts/mutants.

It reads tokens, not the language: a mutation may not compile, and the caller then takes another."""

import re
from collections import namedtuple

# In `path`, the text from `begin` to before `end` becomes `text`.
Mutation = namedtuple("Mutation", "path kind begin end text")
Token = namedtuple("Token", "text begin end")

TOKEN = re.compile(r"""[A-Za-z_]\w*|\d[\w.]*|->|<<=|>>=|\.\.\.|\+\+|--|<<|>>|[<>=!+*/%&|^-]=|
    &&|\|\||\#\#|[^\s\w]""", re.VERBOSE)
NOT_CODE = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|
    ^[ \t]*\#(?:\\\n|[^\n])*""", re.VERBOSE | re.DOTALL | re.MULTILINE)
TURNED = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
BEGINS_STATEMENT = {";", "{", "}", ":", "else"}
NOT_EXPRESSION = {"return", "if", "for", "while", "switch", "do", "else", "case", "default", "goto",
                  "struct", "enum", "union", "static", "const", "typedef", "extern", "inline"}
AFTER_NAME = {"(", "=", "->", ".", "[", "++", "--", "+=", "-=", "*=", "/=", "|=", "&=", "^=", "<<=",
              ">>=", "%="}


def tokens_of(text):
    """Without comments, strings and directives; a string becomes a token of its own."""
    def blank(match):
        kept = '"' if match[0][0] in "\"'" else " "
        return re.sub(r"[^\n]", kept, match[0])
    code = NOT_CODE.sub(blank, text)
    code = re.sub(r'""+', lambda match: "_" * len(match[0]), code)
    return [Token(match[0], match.start(), match.end()) for match in TOKEN.finditer(code)]


def closing(tokens, at):
    """The index of the parenthesis that closes the one at `at`, or None."""
    depth = 0
    for i in range(at, len(tokens)):
        depth += (tokens[i].text in "([{") - (tokens[i].text in ")]}")
        if depth == 0:
            return i
    return None


def depths(tokens):
    """How many braces each token is within: 0 is outside of functions."""
    depth, result = 0, []
    for token in tokens:
        depth -= token.text == "}"
        result.append(depth)
        depth += token.text == "{"
    return result


def comparison_turned(tokens, i):
    if tokens[i].text in TURNED:
        yield "comparison turned", tokens[i].begin, tokens[i].end, TURNED[tokens[i].text]


def bound_off_by_one(tokens, i):
    if tokens[i].text in ("<", "<=", ">", ">="):
        yield "bound off by one", tokens[i].end, tokens[i].end, " 1 +"
    if tokens[i].text in "+-" and i + 1 < len(tokens) and tokens[i + 1].text in ("1", "1u") and \
            tokens[i - 1].text not in ("return", "case") and \
            re.match(r"[\w)\]]", tokens[i - 1].text):
        yield "bound off by one", tokens[i].begin, tokens[i + 1].end, ""


def flag_not_set(tokens, i):
    after = tokens[i + 2].text if i + 2 < len(tokens) else ""
    is_name = re.match(r"[A-Za-z_]", tokens[i + 1].text) and after not in ("(", "[", ".", "->")
    if tokens[i].text == "|" and is_name:
        yield "flag not set", tokens[i].begin, tokens[i + 1].end, ""
    if tokens[i].text == "|=":
        yield "flag not set", tokens[i].end, tokens[i].end, " 0 &"


def is_all_of_condition(tokens, i):
    """Whether the negation at `i` is that of if (!x), which is a mutation already."""
    if tokens[i - 1].text != "(" or tokens[i - 2].text not in ("if", "while"):
        return False
    end = closing(tokens, i - 1)
    return end is not None and not any(token.text in ("&&", "||") for token in tokens[i:end])


def condition_negated(tokens, i):
    if tokens[i].text in ("if", "while") and tokens[i + 1].text == "(":
        end = closing(tokens, i + 1)
        if end:
            yield "condition negated", tokens[i + 1].begin, tokens[end].end, None
    if tokens[i].text == "!" and not is_all_of_condition(tokens, i):
        yield "condition negated", tokens[i].begin, tokens[i].end, ""


def begins_statement(tokens, i):
    before = tokens[i - 1].text
    if before in BEGINS_STATEMENT:
        return True
    if before != ")":
        return False
    depth = 0
    for j in range(i - 1, 0, -1):  # if (...), for (...), while (...)
        depth += (tokens[j].text == ")") - (tokens[j].text == "(")
        if depth == 0:
            return tokens[j - 1].text in ("if", "for", "while")
    return False


def statement_dropped(tokens, i):
    first, second = tokens[i].text, tokens[i + 1].text if i + 1 < len(tokens) else ""
    is_jump = first in ("break", "continue") and second == ";"
    is_expression = (first not in NOT_EXPRESSION and re.match(r"[A-Za-z_]", first) and
                     second in AFTER_NAME) or first in ("*", "++", "--")
    if not (is_jump or is_expression) or not begins_statement(tokens, i):
        return
    end, depth = i, 0
    while end < len(tokens) and (depth or tokens[end].text != ";"):
        depth += (tokens[end].text in "([{") - (tokens[end].text in ")]}")
        if depth < 0:
            return
        end += 1
    if end < len(tokens):
        yield "statement dropped", tokens[i].begin, tokens[end].end, ";"


OPERATORS = (comparison_turned, bound_off_by_one, flag_not_set, condition_negated,
             statement_dropped)


def mutations_of(path, text):
    """All of one source, in its order. Constants and declarations outside of functions are left."""
    tokens = tokens_of(text)
    for i, depth in enumerate(depths(tokens[:-3])):
        if depth == 0:
            continue
        for operator in OPERATORS:
            for kind, begin, end, new in operator(tokens, i):
                if new is None:
                    new = f"(!{text[begin:end]})"
                yield Mutation(path, kind, begin, end, new)
