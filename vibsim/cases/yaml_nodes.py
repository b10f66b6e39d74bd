"""YAML text to a tree of mappings and texts in which every key and value knows its place; and a case as such.

Built from the parser's events, not from loaded objects: values stay the text that the user wrote (3:7:0.05,
1e-8, 010, no). What a case file has no use for (repeated keys, nulls, tags, anchors, aliases, merge keys,
lists other than those of LISTS) is reported and left out.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple, NoReturn

import yaml
from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceStartEvent,
)

from vibsim.cases.problems import CaseError, Problem, did_you_mean, shown, unstorable

DEEPEST = 8  # nesting; a case needs 5
MOST_VALUES = 10_000  # a case needs about 40, a chain of a hundred bodies 2,000
LISTS = ("between", "terms")  # keys whose value is a list: the two ends of a part, the harmonics of a force
VALUES = ("extends", "name", "title", "vibsim_case")  # keys of a file that are no sections
NULLS = ("", "~", "null", "Null", "NULL")
FAST_PARSER = getattr(yaml, "CSafeLoader", None)
# what both parsers read alike: plain characters, and comments
BOTH_READ = re.compile(r"(?:[\n A-Za-z0-9:.,=+^_(){}\[\]'\"/<;~-]|(?<![^\n ])#[ -~]*$)*", re.MULTILINE)


class Place(NamedTuple):
    """A place in a file, counted from 1; no line for an override."""

    file: str
    line: int | None = None
    column: int | None = None

    def problem(self, key: str, message: str) -> Problem:
        return Problem(self.file, self.line, self.column, key, message)


class Text(NamedTuple):
    """A value, as written; `spelt` is how it stands in the file where that is not the text itself."""

    text: str
    place: Place
    spelt: str = ""


def place_inside(place: Place, text: str, spelt: str, at: int) -> Place:
    """The place of a character of a value; in quotes, and on several lines, by counting what is no blank."""
    if place.line is None or place.column is None:
        return place
    if not spelt:
        return Place(place.file, place.line, place.column + at)
    count = sum(not character.isspace() for character in text[:at])
    first = next((character for character in text if not character.isspace()), "")
    i = spelt.find(first, 1 if spelt[:1] in "'\"|>" else 0)
    while i < len(spelt) and (count or spelt[i].isspace()):
        count -= not spelt[i].isspace()
        i += 1
    before = spelt[:i]
    column = i - before.rfind("\n") if "\n" in before else place.column + i
    return Place(place.file, place.line + before.count("\n"), column)


class Broken(NamedTuple):
    """A value that has been reported already; it stands here so that its key is not called missing."""

    place: Place


@dataclass(frozen=True, slots=True)
class Mapping:
    """Keys, their places and their values, in file order; a list has the keys "1", "2", ..."""

    place: Place
    values: dict[str, "Node"] = field(default_factory=dict)
    key_places: dict[str, Place] = field(default_factory=dict)
    is_list: bool = False

    def put(self, key: str, place: Place, value: "Node") -> None:
        self.values[key] = value
        self.key_places[key] = place


Node = Mapping | Text | Broken


class _TooMuch(Exception):
    """Reading stops here: too deep, too many values, or a second document."""


def read_yaml(text: str, file: str) -> tuple[Mapping | None, list[Problem]]:
    """Parse one YAML document.

    Returns the tree (None where the text holds no mapping) and all problems found. A syntax error is
    a problem too; nothing is read after it.

    Where PyYAML has libyaml, ten times as fast, that reads first; what it finds fault with is read again by
    the parser that is there everywhere, so that problems are worded and placed alike.
    """
    if FAST_PARSER and BOTH_READ.fullmatch(text):
        root, problems = _read_by(FAST_PARSER, text, file)
        if not problems:
            return root, problems
    return _read_by(yaml.SafeLoader, text, file)


def _read_by(parser: Any, text: str, file: str) -> tuple[Mapping | None, list[Problem]]:
    """Result of `read_yaml`, by a parser of PyYAML."""
    reader = _Reader(file, text)
    try:
        root = reader.document(yaml.parse(text, Loader=parser))
    except _TooMuch:
        return None, reader.problems
    except yaml.YAMLError as error:
        reader.problems.append(_syntax_problem(error, file))
        return None, reader.problems
    return root, reader.problems


class _Reader:
    """Builds the tree of one file from its events."""

    def __init__(self, file: str, text: str):
        self.file, self.text = file, text
        self.problems: list[Problem] = []
        self.count = 0

    def document(self, events: Iterator[Event]) -> Mapping | None:
        root: Node | None = None
        for event in events:
            if isinstance(event, DocumentStartEvent) and root is not None:
                self.stop(self.place(event), "a case file holds one YAML document; a second one starts here")
            elif isinstance(event, MappingStartEvent):
                root = self.node(event, events, "", self.place(event), 1)
            elif isinstance(event, NodeEvent) and getattr(event, "value", None) != "":
                value_text = shown(getattr(event, "value", "a list"))
                self.stop(self.place(event), f"must be a mapping of sections, got {value_text}")
        if root is None:
            self.report(
                Place(self.file, 1, 1), "", "is empty; a case needs at least blocks and coupling, or bodies"
            )
        return root if isinstance(root, Mapping) else None

    def node(self, event: Event, events: Iterator[Event], key: str, key_place: Place, depth: int) -> Node:
        place = self.place(event)
        self.counted(event, depth)
        broken = self.forbidden(event, key, place)
        if isinstance(event, MappingStartEvent):
            mapping = self.mapping(event, events, key, depth)
            return Broken(place) if broken else mapping
        if isinstance(event, SequenceStartEvent):
            if key.rpartition(".")[2] in LISTS:
                listed = self.items(event, events, key, depth)
                return Broken(place) if broken else listed
            self.skip(events, depth=1)
        if broken:
            return Broken(place)
        if not isinstance(event, ScalarEvent):
            allowed = "a single value" if "." in key or key in VALUES else "a mapping"
            hint = did_you_mean(key.rpartition(".")[2], LISTS)
            return self.report(place, key, f"lists are not used here{hint}; write {allowed}")
        if not event.style and event.value in NULLS:
            return self.report(key_place, key, _null_message(key, event.value))
        return Text(event.value, place, self.spelling(event))

    def mapping(self, start: Event, events: Iterator[Event], prefix: str, depth: int) -> Mapping:
        mapping = Mapping(self.place(start))
        for event in events:
            if isinstance(event, MappingEndEvent):
                break
            name = self.key(event, events, prefix)
            place = self.place(event)
            key = f"{prefix}.{name}" if prefix else str(name)
            if name is None:
                self.skip(events, isinstance(next(events), CollectionStartEvent))
                continue
            value = self.node(next(events), events, key, place, depth + 1)
            if name in mapping.values:
                first = mapping.key_places[name].line
                self.report(place, key, f"is given twice; first on line {first}")
                continue
            mapping.put(name, place, value)
        return mapping

    def items(self, start: Event, events: Iterator[Event], prefix: str, depth: int) -> Mapping:
        """A list, as a mapping with the keys "1", "2", ..."""
        mapping = Mapping(self.place(start), is_list=True)
        for event in events:
            if isinstance(event, CollectionEndEvent):
                break
            name = str(len(mapping.values) + 1)
            place = self.place(event)
            mapping.put(name, place, self.node(event, events, f"{prefix}.{name}", place, depth + 1))
        return mapping

    def key(self, event: Event, events: Iterator[Event], prefix: str) -> str | None:
        """The text of a mapping's key; None where it is no text, which is reported."""
        place = self.place(event)
        if isinstance(event, ScalarEvent):
            if self.forbidden(event, prefix, place):
                return None
            if event.value == "<<" and not event.style:
                self.report(place, prefix, "merge keys are not used in case files; use extends: OTHER.yaml")
                return None
            return event.value
        if isinstance(event, CollectionStartEvent):
            self.skip(events, depth=1)
        self.report(place, prefix, "a key must be a plain word")
        return None

    def skip(self, events: Iterator[Event], depth: int) -> None:
        """Read past the rest of a list or mapping of this depth."""
        while depth:
            event = next(events)
            self.counted(event, depth)
            depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)

    def counted(self, event: Event, depth: int) -> None:
        """Stop at what would take long and is no case: the parser's time grows with depth and count."""
        self.count += isinstance(event, NodeEvent)
        if depth > DEEPEST:
            self.stop(self.place(event), f"nested more than {DEEPEST} deep; a case needs 5")
        if self.count > MOST_VALUES:
            self.stop(self.place(event), f"more than {MOST_VALUES} values; a case needs about 40")

    def forbidden(self, event: Event, key: str, place: Place) -> bool:
        """Report aliases, anchors, tags and characters that no file can hold; True where there is one."""
        anchor, tag = getattr(event, "anchor", None), getattr(event, "tag", None)
        if anchor is not None:
            what = f"aliases are not used in case files, got *{shown(anchor)}"
            if not isinstance(event, AliasEvent):
                what = f"anchors are not used in case files, got &{shown(anchor)}"
            self.report(place, key, f"{what}; write the value again, or use extends")
        elif tag is not None:
            name = str(tag).replace("tag:yaml.org,2002:", "!!")
            self.report(
                place, key, f"tags are not used in case files, got {shown(name)}; write the plain value"
            )
        character = unstorable(getattr(event, "value", ""))
        if character:
            self.report(place, key, f"holds {character}, which no file can")
        return anchor is not None or tag is not None or bool(character)

    def spelling(self, event: ScalarEvent) -> str:
        """A value as it stands in the file, where it is in quotes or on several lines; else nothing."""
        start, end = event.start_mark, event.end_mark
        if not (start and end) or (not event.style and start.line == end.line):
            return ""
        return self.text[start.index : end.index]

    def report(self, place: Place, key: str, message: str) -> Broken:
        self.problems.append(place.problem(key, message))
        return Broken(place)

    def stop(self, place: Place, message: str) -> NoReturn:
        self.report(place, "", message)
        raise _TooMuch

    def place(self, event: Event) -> Place:
        mark = event.start_mark
        return Place(self.file, mark.line + 1, mark.column + 1) if mark else Place(self.file, 1, 1)


def _null_message(key: str, value: str) -> str:
    """Message for a key without a value; commas and colons out of place make such keys."""
    section, _, name = key.rpartition(".")
    what = f"must not be null, got {value}" if value else "has no value"
    if value == "" and name[:1].isdigit():
        return "is read as a key of its own; write decimals with a point, not a comma"
    if value == "" and ":" in name:
        return "is read as a key without a value; leave a space behind the colon"
    if section:
        return f"{what}; write one, or leave the key out"
    return f"{what}; write the section's keys, leave it out, or write none"


SYNTAX_HINTS = {
    r"'\t'": "indent with spaces, not with tabs",
    "mapping values are not allowed here": "look for a second colon, a missing quote or a wrong indent",
    "but got '<stream end>'": "a brace or quote is not closed",
    "<block end>": "look at the indent of this line",
}


def _syntax_problem(error: yaml.YAMLError, file: str) -> Problem:
    """A YAML syntax error in the words of the parser, with a hint for what people trip over."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or "cannot be read"
    context = getattr(error, "context", None)
    hints = [f"; {hint}" for words, hint in SYNTAX_HINTS.items() if words in what]
    message = f"not valid YAML: {what}{f', {context}' if context else ''}{''.join(hints)}"
    return Problem(file, line, column, "", message)


# Bytes of a case file.


LARGEST_FILE = 1_000_000  # bytes
HDF5_SIGNATURE = b"\x89HDF"
ASCII_TEXT = re.compile("[\t\n\r -~]*")
CONTROL = "[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"  # what YAML forbids


def decoded(raw: bytes, name: str) -> str:
    """Bytes of a case file as text. Raises CaseError for large, binary and non-UTF-8 files."""
    if raw.startswith(HDF5_SIGNATURE):
        raise CaseError([Problem(name, None, None, "", "is an HDF5 file, not a YAML case file")])
    if len(raw) > LARGEST_FILE:
        raise CaseError([Problem(name, None, None, "", "is larger than 1 MB; a case file has about 2 kB")])
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        what = f"is not UTF-8 text (byte 0x{raw[error.start]:02x}); save the file as UTF-8"
        raise CaseError([_at(name, raw[: error.start].decode("utf-8", "replace"), what)]) from None
    control = None if ASCII_TEXT.fullmatch(text) else re.search(CONTROL, text)
    if control:
        what = f"holds the control character 0x{ord(control[0]):02x}; is it a binary file?"
        raise CaseError([_at(name, text[: control.start()], what)])
    return text


def _at(name: str, before: str, message: str) -> Problem:
    """A problem right behind the text `before`."""
    line = before.count("\n") + 1
    column = len(before) - (before.rfind("\n") + 1) + 1
    return Problem(name, line, column, "", message)


# Case files as one plain tree of texts, every place kept.


@dataclass
class Tree:
    """A case before validation.

    Attributes
    ----------
    values : nested dict of texts
    places : dotted key -> place of its value
    key_places : dotted key -> place of the key itself
    spelt : dotted key -> its value as it stands in the file, where that is in quotes
    texts, tables : dotted key -> a formula as it was before tables of files were put in; of each of them the
        place, the length of its name and its own length
    root : where the case begins, the place of what is missing
    problems : what reading found
    complete : False where a file could not be read, so that keys may be missing for that reason
    """

    values: dict[str, Any]
    root: Place
    places: dict[str, Place] = field(default_factory=dict)
    key_places: dict[str, Place] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    complete: bool = True
    spelt: dict[str, str] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    tables: dict[str, list[tuple[int, int, int]]] = field(default_factory=dict)

    def place(self, key: str) -> Place:
        """Place of a key's value, or of the section around it where it is missing."""
        return self.places[key] if key in self.places else self.key_place(key.rpartition(".")[0])

    def place_inside(self, key: str, at: int) -> Place:
        """Place of a character of a key's value."""
        text = self.texts.get(key)
        if text is None:
            value: Any = self.values
            for name in key.split("."):
                value = value.get(name) if isinstance(value, dict) else None
            text = str(value)
        for start, before, after in self.tables.get(key, ()):
            at = at if at <= start else at - after + before if at >= start + after else start
        return place_inside(self.place(key), text, self.spelt.get(key, ""), at)

    def key_place(self, key: str) -> Place:
        """Place of a key itself, or of the section around it where it is missing."""
        while key:
            if key in self.key_places:
                return self.key_places[key]
            key = key.rpartition(".")[0]
        return self.root
