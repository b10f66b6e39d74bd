"""How hard the pages are to read: words per sentence, and the share of sentences of more than 30 words.

Code, tables, headings and formulas are left out; a piece of code within a sentence counts as one word.

    python -m tests.docs.reading_ease              every page
    python -m tests.docs.reading_ease --long PAGE  its sentences of more than 30 words
"""

import re
import sys
from pathlib import Path

from tests.docs.pages import PAGES, name_of

LONG = 30  # words
BLOCKS = re.compile(r"^(```|\$\$).*?^\1`*$|^:::+\{[^\n]*$|^:::+$|^---\n.*?^---$", re.DOTALL | re.MULTILINE)
LEFT_OUT = re.compile(r"(    |#|\||<|- \[ \]|\(.*\)=$)")  # indented code, headings, rows of tables, marks
ITEM = re.compile(r"(?:[-*:]|\d+\.) +")
END = re.compile(r"(?<=[.?!])[)\"']*\s+(?=[\"'(*_\[]*(?:[A-Z0-9`*(]|vibsim\b))")
WORD = re.compile(r"[^\W_][\w'.,/%^-]*")
NOT_ENDS = re.compile(r"\b(Eqs?|Figs?|No|vol|pp|cf|vs|approx|e\.g|i\.e|[A-Z])\. ")


def sentences(text):
    """The sentences of a page of Markdown, each as a list of its words."""
    found = []
    for paragraph in paragraphs(BLOCKS.sub("\n\n", text)):
        for sentence in END.split(NOT_ENDS.sub(r"\1 ", plain(paragraph))):
            words = WORD.findall(sentence)
            if len(words) > 1:
                found.append(words)
    return found


def paragraphs(text):
    """The paragraphs of running text; each item of a list is one of its own."""
    lines = []
    for line in [*text.splitlines(), ""]:
        left_out = LEFT_OUT.match(line) and not (lines and line.startswith("    "))
        if not line.strip() or left_out or ITEM.match(line.lstrip()):
            if lines:
                yield " ".join(lines)
            lines = [] if left_out or not line.strip() else [ITEM.sub("", line.lstrip(), count=1)]
        else:
            lines.append(line.strip())


def plain(paragraph):
    """A paragraph without marks: links by their text, code and formulas as one word each."""
    paragraph = re.sub(r"`[^`]+`", "Code", paragraph)
    paragraph = re.sub(r"\$[^$]+\$", "F", paragraph)
    return re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", paragraph).replace("**", "").replace("*", "")


def measure(path):
    """(number of sentences, words per sentence, share of sentences over 30 words) of a page."""
    lengths = [len(words) for words in sentences(path.read_text(encoding="utf-8"))]
    if not lengths:
        return 0, 0.0, 0.0
    return len(lengths), sum(lengths) / len(lengths), sum(n > LONG for n in lengths) / len(lengths)


def main(arguments):
    if arguments[:1] == ["--long"]:
        for name in arguments[1:]:
            for words in sentences(Path(name).read_text(encoding="utf-8")):
                if len(words) > LONG:
                    print(len(words), " ".join(words))
        return
    print("sentences  words per sentence  over 30 words  page")
    for path in [Path(name).resolve() for name in arguments] or PAGES:
        number, words, share = measure(path)
        print(f"{number:9d}  {words:18.1f}  {share:12.1%}  {name_of(path)}")


if __name__ == "__main__":
    main(sys.argv[1:])
