"""What each command prints with --json has the shape that `docs/guide/json.schema.json` gives, and no other keys."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import Run
from jsonschema import Draft202012Validator, ValidationError
from scenario_texts import GRAPH, PLACES_NEARBY, RELAXED_CUP, cup_scenario

from experiments import scenarios
from experiments.sweep import workers

FILE = Path(__file__).parents[3] / "docs" / "guide" / "json.schema.json"

Check = Callable[[str, Any], None]


def closed(schema: Any) -> Any:
    """Return a schema in which objects have no keys but those that it names."""
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    parts = {key: closed(part) for key, part in schema.items()}
    is_object = schema.get("type") == "object" and "properties" in schema
    return {"additionalProperties": False} | parts if is_object else parts


@pytest.fixture(scope="module")
def check() -> Check:
    """Return a function that fails unless a value has the shape of a definition of the schema."""
    schema = closed(json.loads(FILE.read_text(encoding="utf-8")))
    Draft202012Validator.check_schema(schema)

    def validate(kind: str, value: Any) -> None:
        Draft202012Validator(schema | {"$ref": f"#/$defs/{kind}"}).validate(value)

    return validate


@pytest.fixture
def cup(run: Run) -> Path:
    """A scenario in the current folder, soon carried out."""
    file = Path("cup.toml")
    file.write_text(cup_scenario(places=PLACES_NEARBY))
    return file


@pytest.mark.slow
@pytest.mark.parametrize("name", scenarios.names())
def test_fronts_and_plans_of_every_scenario_that_ships(run: Run, check: Check, name: str) -> None:
    for command in ("front", "plan"):
        check(command, run(command, name, "--json").json)


def test_every_relaxation(run: Run, check: Check) -> None:
    rule = '\n[[rules]]\nname = "dry"\nformula = "G !cup_tub"\nskip = 1\n'
    Path("relaxed.toml").write_text(RELAXED_CUP.replace("\n[preference]", rule + "\n[preference]"))
    front = run("front", "relaxed.toml", "--json").json
    check("front", front)
    bought = [purchase for plan in front["front"] for purchase in plan["relaxations"]]
    assert {key for purchase in bought for key in purchase} >= {"assume", "skip", "rule"}
    for plan in front["front"]:
        check("plan_of_front", plan)


def test_searches_without_a_plan_and_searches_that_are_stopped(run: Run, check: Check, cup: Path) -> None:
    Path("never.toml").write_text(GRAPH.replace("F plant", "F rock"))
    shapes = (("never.toml",), ("cup.toml", "--max-cost", "1"), ("cup.toml", "--max-seconds", "0"))
    for arguments in shapes:
        for command in ("front", "plan"):
            printed = run(command, *arguments, "--json").json
            check(command, printed)
            assert printed.get("plan") is None and not printed.get("front")
            assert ("ended" in printed) == ("--max-seconds" in arguments)
            assert ("reason" in printed) == ("--max-seconds" not in arguments)


def test_runs_and_sweeps(run: Run, check: Check, cup: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        workers, "on_this_machine", lambda sweep, numbers, **options: (sweep.record(k) for k in numbers)
    )
    faults = ("--fault", "miss:1@2", "--fault", "slip@40")
    printed = run("run", "cup.toml", "--no-video", "--seed", "3", *faults, "--json").json
    check("run", printed)
    assert {event["kind"] for event in printed["events"]} >= {"grasped", "placed", "fault", "retry", "not injected"}
    check("verify", run("verify", "out/cup/cost.npz", "--json").json)
    check("plan", run("run", "cup.toml", "--max-cost", "1", "--json").json)
    check("sweep", run("sweep", "cup.toml", "--rollouts", "1", "--faults", "miss", "--json").json)


@pytest.mark.parametrize("arguments", [("list",), ("robots",), ("doctor",)])
def test_what_there_is(run: Run, check: Check, arguments: tuple[str, ...]) -> None:
    check(arguments[0], run(*arguments, "--json").json)


def test_checks(run: Run, check: Check, cup: Path) -> None:
    Path("never.toml").write_text(GRAPH.replace("F plant", "F rock"))
    for name in ("cup.toml", "example", "never.toml"):
        check("check", run("check", name, "--json").json)


def test_a_key_more_or_less_is_not_accepted(run: Run, check: Check) -> None:
    Path("graph.toml").write_text(GRAPH)
    front = run("front", "graph.toml", "--json").json
    check("front", front)
    for wrong in (front | {"more": 1}, {key: front[key] for key in front if key != "complete"}):
        with pytest.raises(ValidationError):
            check("front", wrong)


def test_the_page_names_every_key_that_a_front_a_plan_and_a_run_have() -> None:
    text = FILE.with_name("json.md").read_text(encoding="utf-8")
    definitions = json.loads(FILE.read_text(encoding="utf-8"))["$defs"]
    shapes = [definitions[kind] for kind in ("front", "plan", "run", "relaxation", "plan_of_front", "reason", "event")]
    keys = {key for shape in shapes for part in (shape, *shape.get("anyOf", ())) for key in part.get("properties", ())}
    assert {key for key in keys if f'"{key}"' not in text and f"`{key}`" not in text} == set()
