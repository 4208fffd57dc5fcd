"""Scenario files to start from, one for each kind of model, with every key explained in its comments."""

from __future__ import annotations

from importlib.resources import files

KINDS = ("grid", "manipulation", "graph")


def starter(kind: str, *, file: str) -> str:
    """Return the text of a scenario that plans as it is.

    Args:
        kind: one of `KINDS`.
        file: name of the new file, for its first comment and the calls in it.
    """
    return files(__package__).joinpath(f"{kind}.toml").read_text(encoding="utf-8").replace("@FILE@", file)
