"""Scenario files to start from, one for each kind of model, with comments on its keys."""

from importlib.resources import files

KINDS = ("grid", "manipulation", "graph")


def starter(kind: str, *, file: str) -> str:
    """Return the text of a scenario of one of `KINDS` that can be planned as it is; its comments name `file`."""
    return files(__package__).joinpath(f"{kind}.toml").read_text(encoding="utf-8").replace("@FILE@", file)
