"""The format of the 9th DIMACS implementation challenge on shortest paths: arcs in `.gr`, coordinates in `.co`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

from prefplan.errors import ModelError
from prefplan.models.graph_files.network import Sink

CHALLENGE_DEGREES = 1e-6
"""Unit of the challenge's coordinates, degrees."""


MOST_DIGITS = 18
"""Longer numbers of nodes and arcs are refused, as Python refuses to parse those of thousands of digits."""


def read_arcs(file: BinaryIO, sink: Sink) -> None:
    """Pass the arcs of a `.gr` file to a sink, with their weight as the attribute `cost`.

    Raises:
        ModelError: the file does not have this format, or the sink refuses an arc; most messages begin with the line.
    """
    lines = _lines(file)
    nodes, arcs = _heading(lines, "p sp NODES ARCS")
    read = 0
    for line, words in lines:
        try:
            _check_record(words, "a NODE NODE COST", nodes, ends=2)
            sink.edge(words[1].decode(), words[2].decode(), {"cost": words[3]})
        except ModelError as error:
            raise ModelError(f"line {line}: {error}") from None
        read += 1
    if read != arcs:
        raise ModelError(f"the line 'p sp' says {arcs} arcs, and there are {read}")


def read_coordinates(file: BinaryIO, sink: Sink) -> None:
    """Pass the nodes of a `.co` file to a sink.

    Raises:
        ModelError: as in `read_arcs`.
    """
    lines = _lines(file)
    (nodes,) = _heading(lines, "p aux sp co NODES")
    sink.has_degrees(CHALLENGE_DEGREES)
    for line, words in lines:
        try:
            _check_record(words, "v NODE X Y", nodes, ends=1)
            sink.node(words[1].decode(), {"x": words[2], "y": words[3]})
        except ModelError as error:
            raise ModelError(f"line {line}: {error}") from None


def _lines(file: BinaryIO) -> Iterator[tuple[int, list[bytes]]]:
    """Yield (number, words) of every line that is neither empty nor a comment."""
    for number, line in enumerate(file, start=1):
        words = line.split()
        if words and words[0] != b"c":
            yield number, words


def _heading(lines: Iterator[tuple[int, list[bytes]]], form: str) -> list[int]:
    """Return the numbers in the first line, which must have a form such as `p sp NODES ARCS`."""
    line, words = next(lines, (1, []))
    fixed = [word for word in form.encode().split() if word.islower()]
    numbers = words[len(fixed) :]
    if len(words) != len(form.split()) or words[: len(fixed)] != fixed or not all(map(_is_number, numbers)):
        raise ModelError(f"line {line}: must be '{form}', not {_shown(words)}")
    return [int(word) for word in numbers]


def _check_record(words: list[bytes], form: str, nodes: int, *, ends: int) -> None:
    """Check a line of four words, of which the `ends` after the first are nodes."""
    if len(words) != 4 or words[0] != form[0].encode():
        raise ModelError(f"must be '{form}', not {_shown(words)}")
    for word in words[1 : 1 + ends]:
        if not _is_number(word) or not 1 <= int(word) <= nodes:
            raise ModelError(f"node {word.decode(errors='replace')} is not one of 1 to {nodes}")


def _is_number(word: bytes) -> bool:
    return word.isdigit() and len(word) <= MOST_DIGITS


def _shown(words: list[bytes]) -> str:
    return repr(b" ".join(words).decode(errors="replace"))
