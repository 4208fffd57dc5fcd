"""The scenario files that ship: their names, folder and introductions; `prefplan.load` reads one."""

import re
from itertools import dropwhile, takewhile

from prefplan.scenario.files import FOLDER, names

__all__ = ["FOLDER", "first_sentence", "introduction", "names"]


def first_sentence(text: str) -> str:
    """Return the first sentence of `introduction`."""
    return re.split(r"(?<=[.!?])\s", introduction(text), maxsplit=1)[0]


def introduction(text: str) -> str:
    """Return the first paragraph of a file's opening comment on one line, without the file's name at its start."""
    opening = re.match(r"(?:[ \t]*#[^\n]*\n)*", text)
    assert opening is not None
    lines = [line.strip().lstrip("#").strip() for line in opening[0].splitlines()]
    paragraph = " ".join(takewhile(bool, dropwhile(lambda line: not line, lines)))
    about = re.sub(r"^\S+\.toml: ", "", paragraph)
    return about[:1].upper() + about[1:]
