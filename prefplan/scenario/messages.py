"""What is wrong with a scenario file, in a person's words: the key, the mistake and what would be right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from prefplan.errors import choices

_KINDS: dict[Any, list[str]] = {
    "model": ["graph", "grid", "manipulation"],
    "preference": ["order", "weighted-sum", "max", "deadline", "expression", "sum"],
}


def first_problem(error: ValidationError, data: Any) -> str:
    """Return the first problem as `key.path: what is wrong`."""
    problem = error.errors()[0]
    context, location = problem.get("ctx", {}), problem["loc"]
    match problem["type"]:
        case "unknown_key":
            return f"{_key_path(location, data, context['key'])}: {context['message']}"
        case "missing" if isinstance(location[-1], int):
            return f"{_key_path(location[:-1], data)}: too few entries, at least {location[-1] + 1} are needed"
        case "missing":
            return f"{_key_path(location[:-1], data, location[-1])}: missing"
        case "union_tag_not_found":
            return f"{_key_path(location, data, 'kind')}: missing {choices('', _kinds(location))}"
        case "union_tag_invalid":
            wrong = str(context["tag"])
            return f"{_key_path(location, data, 'kind')}: unknown kind {wrong!r} {choices(wrong, _kinds(location))}"
        case "too_long":
            return (
                f"{_key_path(location, data)}: at most {context['max_length']} entries, not {context['actual_length']}"
            )
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{_key_path(location, data)}: must be a table"
    message = problem["msg"].removeprefix("Input ").replace("tuple", "list")
    return f"{_key_path(location, data)}: {message[0].lower()}{message[1:]}"


def _kinds(location: Sequence[Any]) -> list[str]:
    """Return the valid kinds of a table; a sum's terms may be everything but sums."""
    return _KINDS[location[-1]] if location[-1] in _KINDS else _KINDS["preference"][:-1]


def _key_path(location: Sequence[Any], data: Any, key: Any = None) -> str:
    """Return a path of keys as a person would write it, leaving out the decoder's own steps into unions."""
    steps = list(location)
    if steps[:1] in (["model"], ["preference"]):
        del steps[1:2]
    if steps[:2] == ["preference", "terms"]:
        del steps[3:4]
    text = ""
    for step in steps:
        if isinstance(step, int) and isinstance(data, Sequence) and step < len(data):
            text += f"[{step}]"
        elif isinstance(data, Mapping) and step in data:
            text += f".{step}"
        else:
            continue
        data = data[step]
    return (text if key is None else f"{text}.{key}").removeprefix(".")
