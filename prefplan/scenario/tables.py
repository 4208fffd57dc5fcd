"""Decoding of a scenario file's values into types: the fields of a dataclass are the keys of its table.

A field's metadata may rename its key, `{"key": "from"}`, or exclude it, `{"key": None}`. Dataclasses whose field `name`
is excluded are written as a table of tables, each under its name.
"""

import numbers
import types
from collections.abc import Hashable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from decimal import Decimal
from typing import Annotated, Any, TypeVar, Union, cast, get_args, get_origin

from prefplan.errors import ScenarioError, check_known, choices
from prefplan.exact_costs import Number
from prefplan.limits import clocked
from prefplan.text.forms import types_of

T = TypeVar("T")

LONGEST_SHOWN = 60
"""Most characters of a wrong value in a message."""

HEADINGS = {
    "model": "[model]",
    "tasks": "[[tasks]]",
    "rules": "[[rules]]",
    "preference": "[preference]",
    "preferences": "[[preferences]]",
}
"""Headings of a file's tables; without its heading, such a key belongs to the table above it."""

NUMBERS = (numbers.Real, Decimal)

NOUNS: dict[Any, str] = {
    str: "a string",
    int: "an integer",
    NUMBERS: "a number",
    bool: "true or false",
    list: "a list",
    Mapping: "a table",
}
"""What a value is, for messages."""


def decode_table(kind: type[T], table: Any, where: str, *, also: tuple[str, ...] = (), **given: Any) -> T:
    """Return the table of a file with the key `where` as a dataclass.

    Args:
        kind: the dataclass.
        table: the table.
        where: its key, for messages.
        also: further keys that are valid, and ignored.
        **given: fields that do not come from the table.

    Raises:
        ScenarioError: a key is unknown or missing, or a value has the wrong type; the message begins with the key.
        LimitError: a limit was reached.
    """
    keys = _keys(kind)
    valid, path = (*keys, *also), f"{where}." if where else ""
    if not isinstance(table, Mapping):
        raise ScenarioError(f"{where}: must be a table {choices('', valid)}, not {_shown(table)}")
    for key in table:
        if key not in valid and where and key in HEADINGS:
            meant = f"write the heading {HEADINGS[key]}, and below it the keys of its own table"
            raise ScenarioError(f"{path}{key}: is no key of {where}; {meant}")
        if key not in valid:
            raise ScenarioError(f"{path}{key}: unknown key {choices(key, valid)}")
    kinds = types_of(cast(Hashable, kind))
    for key, field in keys.items():
        if key in table:
            given[field.name] = decode(kinds[field.name], table[key], f"{path}{key}")
        elif field.default is field.default_factory is MISSING:
            form = getattr(kinds[field.name], "__metadata__", ())
            wanted = f"; expected {form[0].file}" if form else ""
            raise ScenarioError(f"{path}{key}: missing{wanted}")
    return kind(**given)


def chosen(kinds: Mapping[str, T], table: Any, where: str) -> T:
    """Return the one of `kinds` that the key `kind` of a table names; arguments and errors as in `decode_table`."""
    if not isinstance(table, Mapping):
        raise ScenarioError(f"{where}: must be a table with a kind {choices('', kinds)}, not {_shown(table)}")
    if "kind" not in table:
        raise ScenarioError(f"{where}.kind: missing {choices('', kinds)}")
    kind = table["kind"]
    check_known(f"{where}.kind", "kind", kind, list(kinds), ScenarioError)
    return kinds[kind]


def decode(kind: Any, value: Any, where: str) -> Any:
    """Return a value of a file as a value of a type; arguments and errors as in `decode_table`."""
    origin, parts = get_origin(kind), get_args(kind)
    if kind is Any:
        return value
    if origin is Annotated:
        try:
            return decode(parts[0], value, where)
        except ScenarioError as error:
            # The message of an error in a key of the value says more than how the value is written.
            if "." in str(error).removeprefix(where).partition(":")[0]:
                raise
            raise ScenarioError(f"{where}: must be {parts[1].file}, not {_shown(value)}") from None
    if isinstance(kind, type) and is_dataclass(kind):
        return decode_table(kind, value, where)
    if origin in (Union, types.UnionType):
        return _decode_union(parts, value, where)
    if origin is Mapping:
        return {key: decode(parts[1], entry, f"{where}.{key}") for key, entry in _typed(Mapping, value, where).items()}
    if origin is tuple and parts[-1] is not Ellipsis:
        return _decode_each(parts, value, where)
    if origin is not None:
        return (frozenset if origin is frozenset else tuple)(_decode_several(parts[0], value, where))
    return float(_typed(NUMBERS, value, where)) if kind is float else _typed(kind, value, where)


def _keys(kind: Any) -> dict[str, Field[Any]]:
    """Return the fields of a dataclass that a file may have, by key."""
    named = {field.metadata.get("key", field.name): field for field in fields(kind)}
    return {key: field for key, field in named.items() if key is not None}


def _decode_union(kinds: tuple[Any, ...], value: Any, where: str) -> Any:
    """Decode a value as the one of several types that fits its form; None never occurs in a file."""
    table = isinstance(value, Mapping) and any(get_origin(kind) is Mapping for kind in kinds)
    if set(get_args(Number)) <= set(kinds) and not table:
        return _typed(NUMBERS, value, where)
    generic = [kind for kind in kinds if get_origin(kind)]
    named = [kind for kind in kinds if not get_origin(kind) and kind is not types.NoneType]
    alone = not table and sum(map(is_dataclass, named)) == 1
    for kind in named:
        of_table = is_dataclass(kind) and isinstance(value, Mapping)
        of_table = of_table and (alone or not _keys(kind).keys().isdisjoint(value))
        if of_table or isinstance(value, kind):
            return decode(kind, value, where)
    structured = isinstance(value, (list, Mapping)) or not named
    return decode((generic if generic and structured else named)[0], value, where)


def _decode_several(kind: Any, value: Any, where: str) -> tuple[Any, ...]:
    """Return the entries of a list; a single number, or a single list in a list of lists, may be without brackets."""
    if is_dataclass(kind) and isinstance(kind, type) and any(f.name == "name" and f.metadata for f in fields(kind)):
        tables = _typed(Mapping, value, where).items()
        return tuple(decode_table(kind, table, f"{where}.{name}", name=name) for name, table in tables)
    alone = kind is float and not isinstance(value, list)
    if alone or (get_origin(kind) is tuple and isinstance(value, list) and value and not isinstance(value[0], list)):
        return (decode(kind, value, where),)
    return _decode_each((kind,) * len(_typed(list, value, where)), value, where)


def _decode_each(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    """Return the entries of a list, each of its type."""
    if len(_typed(list, value, where)) != len(kinds):
        raise ScenarioError(f"{where}: must have {len(kinds)} entries, not {len(value)}")
    pairs = enumerate(zip(kinds, value, strict=True))
    return tuple(clocked(decode(kind, entry, f"{where}[{i}]")) for i, (kind, entry) in pairs)


def _typed(kind: Any, value: Any, where: str) -> Any:
    if not isinstance(value, kind) or (kind in (int, NUMBERS) and isinstance(value, bool)):
        raise ScenarioError(f"{where}: must be {NOUNS[kind]}, not {_shown(value)}")
    return value


def _shown(value: Any) -> str:
    """Return a value for a message, its decimals as they are written."""
    if isinstance(value, list):
        text = f"[{', '.join(map(_shown, value))}]"
    elif isinstance(value, Mapping):
        text = f"{{ {', '.join(f'{key} = {_shown(entry)}' for key, entry in value.items())} }}"
    else:
        text = str(value) if isinstance(value, Decimal) else repr(value)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."
