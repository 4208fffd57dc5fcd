"""How a value is written in a scenario file and in Python, for messages about wrong values."""

import numbers
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, fields
from decimal import Decimal
from functools import cache
from types import UnionType
from typing import Annotated, Any, Union, cast, get_args, get_origin, get_type_hints

from prefplan.errors import PrefplanError, describe


@dataclass(frozen=True)
class Form:
    """How a value is written: the metadata of an `Annotated` type.

    Attributes:
        file: how it is written in a scenario file, as the words after `must be`.
        code: how it is written in Python; empty if that is the same.
    """

    file: str
    code: str = ""


@cache
def types_of(kind: Hashable) -> dict[str, Any]:
    """Return the types of a dataclass's fields, by name; cached, since this takes longer than decoding a table."""
    return get_type_hints(kind, include_extras=True)


def check_fields(value: Any, error: type[PrefplanError], prefix: str = "") -> None:
    """Check the fields of a dataclass that have a `Form`, or are mappings whose entries have one.

    Raises:
        PrefplanError: (of the class `error`) a field is not of its type; after the prefix, the message names it and
            says how it is written.
    """
    kinds = types_of(cast(Hashable, type(value)))
    for field in fields(value):
        kind, given = kinds[field.name], getattr(value, field.name)
        entries = {field.name: given}
        if get_origin(kind) is Mapping and get_origin(get_args(kind)[1]) is Annotated:
            if not isinstance(given, Mapping):
                raise error(f"{prefix}{field.name}: must be a dict by name, not {describe(given)}")
            kind = get_args(kind)[1]
            entries = {f"{field.name}.{name}": entry for name, entry in given.items()}
        if get_origin(kind) is Annotated:
            inner, form = get_args(kind)
            for where, entry in entries.items():
                if not fits(inner, entry):
                    raise error(f"{prefix}{where}: must be {form.code or form.file}, not {describe(entry)}")


def fits(kind: Any, value: Any) -> bool:
    """Return whether a value is of a type; parts whose types cannot be checked count as right."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return fits(parts[0], value)
    if origin in (Union, UnionType):
        return any(fits(part, value) for part in parts)
    if origin is Callable:
        return callable(value)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(fits(parts[1], entry) for entry in value.values())
    if origin in (tuple, Sequence, frozenset, Collection):
        if isinstance(value, str | Mapping) or not hasattr(value, "__len__"):
            return False
        if origin is not tuple or parts[-1] is Ellipsis:
            return all(fits(parts[0], entry) for entry in value)
        return len(value) == len(parts) and all(map(fits, parts, value))
    if kind in (int, float, Decimal):
        whole = numbers.Integral if kind is int else (numbers.Real, Decimal)
        return isinstance(value, whole) and not isinstance(value, bool)
    if getattr(kind, "_is_protocol", False):
        return not isinstance(value, type)
    return not isinstance(kind, type) or isinstance(value, kind)
