"""`prefplan list` and `prefplan check`: what they print about scenarios without planning."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import Run, assert_is_error
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments import scenarios
from experiments.checks import checkup, propositions
from experiments.scenarios import first_sentence, introduction
from prefplan.front import UnfinishedError
from prefplan.limits import Limits
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.scenario.decode import load, loads
from sim.capability.answers import Capability
from sim.capability.feasibility import Feasibility

ISLAND = """# island.toml: a ferry that no longer runs. And more.

[model]
kind = "graph"
start = "quay"
propositions = ["ferry"]
transitions = [
  { from = "quay", to = "market", cost = 2.5 },
  { from = "market", to = "quay", cost = 1 },
  { from = "island", to = "quay", cost = 1 },
]
[model.labels]
quay = ["water"]
market = ["fruit"]
island = ["beach"]

[[tasks]]
name = "shop"
formula = "F fruit"

[preference]
kind = "max"
"""
"""Three states, one of which, the island, is unreachable."""


def task(name: str, formula: str, more: str = "") -> str:
    return f'[[tasks]]\nname = "{name}"\nformula = "{formula}"\n{more}\n'


@pytest.fixture
def island(run: Run, tmp_path: Path) -> Path:
    file = tmp_path / "island.toml"
    file.write_text(ISLAND)
    return file


def test_the_list_has_every_scenario_that_ships(run: Run) -> None:
    result = run("list", "--json")
    assert (result.status, result.err) == (0, "")
    found = {one["name"]: one for one in result.json["scenarios"]}
    assert list(found) == scenarios.names()
    assert found["example"] == {
        "name": "example",
        "kind": "grid",
        "tasks": 3,
        "contract": "additive",
        "summary": "The paper's Examples 1-3: a robot on a 3 x 3 grid collects resources.",
    }
    assert all(one["summary"].endswith(".") for one in found.values())


def test_the_list_has_one_line_each_where_nothing_wraps(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS")
    lines = run("list").out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == scenarios.names()


def test_a_pipe_is_as_wide_as_the_environment_says(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, run("list").out.splitlines())) == 60


def test_a_narrow_terminal_cuts_no_word_of_the_list(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run("list").out.split()
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "60")
    lines = re.sub(r"\x1b\[[0-9;]*m", "", run("list").out).splitlines()
    assert max(map(len, lines)) <= 60 and len(lines) < 6 * len(scenarios.names())
    names, about = zip(*(line.split("│")[1:3] for line in lines if line.startswith("│")), strict=True)
    assert "".join(names).split() == scenarios.names()
    assert sum(line.startswith("├") for line in lines) == len(scenarios.names()) - 1
    assert sorted([*scenarios.names(), *" ".join(about).split()]) == sorted(whole[5:])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("# One\n# two. Three.\n[model]\n", "One two."),
        ("# tidy.toml: wash the red block.\n", "Wash the red block."),
        ("[model]\n# One.\n", ""),
        ("# Version 1.5 works", ""),
        ("# No end\n\n# Other.\n", "No end"),
    ],
)
def test_the_first_sentence_of_the_opening_comment(text: str, sentence: str) -> None:
    assert first_sentence(text) == sentence


def test_commands_below_the_opening_paragraph_do_not_belong_to_it() -> None:
    text = "#\n# town.toml: bread is far off.\n# Crackers would do.\n#\n#   prefplan front town.toml\n\n[model]\n"
    assert introduction(text) == "Bread is far off. Crackers would do."


def test_a_scenario_is_summed_up(run: Run, island: Path) -> None:
    result = run("check", "island.toml", "--json")
    assert (result.status, result.err) == (0, "")
    found = result.json
    assert (found["states"], found["reachable"], found["edges"]) == (3, 2, 3)
    assert found["propositions"] == {"beach": 0, "ferry": 0, "fruit": 1, "water": 1}
    (shop,) = found["tasks"]
    assert shop == {
        "name": "shop",
        "formula": "F fruit",
        "automaton_states": 2,
        "cost": 2.5,
        "costs": {"cost": 2.5},
        "achievable": True,
        "relaxations": 0,
        "skip": None,
    }
    assert (found["contract"], found["warnings"], found["scene"]) == ("convex", [], None)


def test_people_read_the_same(run: Run, island: Path) -> None:
    out = run("check", "island.toml").out
    assert "island: a graph model" in out
    assert "3 states (1 cannot be reached), 3 actions" in out
    assert "contract" not in out and "may be" not in out  # nothing that the reader has to know
    (row,) = [line.split() for line in out.splitlines() if line.startswith("shop")]
    assert row == ["shop", "2.5", "2", "states", "F", "fruit"]


@pytest.mark.parametrize(
    ("tasks", "warning"),
    [
        (task("swim", "water | F fruit"), "tasks[0].formula: task swim is satisfied at the start"),
        (task("a", "F (fruit & F water)") + task("b", "F(F water & fruit)"), "task b asks for the same as task a"),
        (task("x", "F (fruit | ferry)"), "tasks[0].formula: no state that can be reached carries 'ferry'"),
        (task("x", "F (fruit | beach)"), "tasks[0].formula: no state that can be reached carries 'beach'"),
    ],
)
def test_likely_mistakes_are_warnings(run: Run, island: Path, tasks: str, warning: str) -> None:
    island.write_text(ISLAND.replace(task("shop", "F fruit"), tasks))
    result = run("check", "island.toml")
    assert result.status == 0
    assert len(result.err.splitlines()) == 1 and result.err.startswith("prefplan: warning: ")
    assert warning in result.err
    assert warning in run("check", "island.toml", "--json").json["warnings"][0]


def test_a_task_that_cannot_be_achieved_has_status_3(run: Run, island: Path) -> None:
    island.write_text(ISLAND.replace("F fruit", "F beach"))
    result = run("check", "island.toml", "--json")
    assert result.status == 3
    assert (result.json["tasks"][0]["cost"], result.json["tasks"][0]["achievable"]) == (None, False)
    assert "task shop can never be satisfied" in result.err


@pytest.mark.parametrize("skip", [3, 2.5])
def test_a_task_that_can_only_be_skipped_is_a_warning(run: Run, island: Path, skip: float) -> None:
    text = ISLAND.replace(task("shop", "F fruit"), task("rest", "F beach", f"skip = {skip}"))
    island.write_text(text.replace('"max"', '"max"\nover = "violation"'))
    result = run("check", "island.toml", "--json")
    (rest,) = result.json["tasks"]
    assert (result.status, rest["cost"], rest["achievable"], rest["skip"]) == (0, None, True, skip)
    assert "it can only be relaxed or skipped" in result.err


def test_a_general_preference_says_what_it_needs(run: Run, island: Path) -> None:
    island.write_text(ISLAND.replace('kind = "max"', 'kind = "expression"\nexpression = "shop"\ncontract = "general"'))
    found = run("check", "island.toml", "--json").json
    assert found["contract"] == "general" and "--max-cost" in found["meaning"]


@pytest.mark.parametrize("name", ["example", "case_study_1"])
def test_no_task_costs_less_in_any_plan_than_alone(name: str) -> None:
    scenario = load(name)
    least = {found["name"]: found["cost"] for found in checkup.check(scenario)["tasks"]}
    for plan in Planner(scenario.problem()).front():
        for task_name, cost in plan.task_costs.items():
            alone = least[task_name]
            assert alone is not None and cost >= alone


def test_the_states_that_can_be_reached_are_those_of_a_plain_walk() -> None:
    system = load("case_study_3").problem().system.listed
    seen, waiting = {system.start}, [system.start]
    while waiting:
        for edge in system.edges(waiting.pop()):
            state = int(system.targets[edge])
            if state not in seen:
                seen.add(state)
                waiting.append(state)
    assert set(np.asarray(propositions.reachable(system)).tolist()) == seen


def test_a_limit_leaves_sizes_unknown(run: Run, island: Path) -> None:
    result = run("check", "island.toml", "--json", "--max-seconds", "0")
    found = result.json
    assert (result.status, found["complete"], found["states"], found["reachable"]) == (0, False, None, None)
    (shop,) = found["tasks"]
    assert (shop["cost"], shop["achievable"], found["warnings"]) == (None, None, [])
    shown = run("check", "island.toml", "--max-seconds", "0")
    assert "states not counted" in shown.out and "unknown" in shown.out
    assert shown.err == "prefplan: stopped by the time limit; not all was checked\n"


def test_ctrl_c_leaves_what_is_known(run: Run, island: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    island.write_text(
        ISLAND.replace(task("shop", "F fruit"), task("shop", "F fruit") + task("swim", "F (fruit & water)"))
    )
    asked: list[str] = []
    best = Planner.best

    def pressed_at_the_second(self: Planner, objective: str) -> Plan:
        asked.append(objective)
        if len(asked) > 1:
            raise KeyboardInterrupt
        return best(self, objective)

    monkeypatch.setattr(Planner, "best", pressed_at_the_second)
    result = run("check", "island.toml", "--json")
    found = result.json
    assert (result.status, result.err) == (130, "prefplan: interrupted\n")
    assert [one["cost"] for one in found["tasks"]] == [2.5, None] and len(asked) == 2
    assert (found["interrupted"], found["complete"], found["states"]) == (True, False, None)


def test_ctrl_c_before_the_start_is_checked_leaves_unknown_whether_the_arm_can_work(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(_: Capability) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Capability, "check_start", pressed)
    (tmp_path / "cup.toml").write_text(cup_scenario())
    result = run("check", "cup.toml", "--json")
    assert (result.status, result.json["scene"], result.json["places"]) == (130, None, None)


def test_what_the_arm_can_do_is_found_once(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "cup.toml").write_text(cup_scenario())
    found = run("check", "cup.toml", "--json").json["places"]

    def asked_again(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(Feasibility, "check", asked_again)
    assert found and run("check", "cup.toml", "--json").json["places"] == found


def test_every_cost_and_preference_is_told(run: Run, island: Path) -> None:
    text = re.sub(r"cost = ([\d.]+)", r"cost = { time = \1, noise = 3 }", ISLAND)
    text += 'of = "noise"\n[[preferences]]\nname = "soon"\nkind = "order"\n'
    island.write_text(text)
    found = run("check", "island.toml", "--json").json
    assert (found["costs"], found["tasks"][0]["costs"]) == (["time", "noise"], {"time": 2.5, "noise": 3})
    contracts = [(one["name"], one["contract"], one["of"]) for one in found["preferences"]]
    assert contracts == [("preference", "convex", "noise"), ("soon", "additive", "time")]
    out = run("check", "island.toml").out
    assert "costs: time, noise" in out and "preference soon, of time: additive contract" in out
    assert "least time  least noise" in out


def test_a_cost_may_be_called_as_a_preference_is_unless_named(run: Run, island: Path) -> None:
    text = re.sub(r"cost = ([\d.]+)", r"cost = { time = \1, preference = 3 }", ISLAND)
    island.write_text(text.replace('[preference]\nkind = "max"\n', ""))
    assert run("check", "island.toml", "--json").json["tasks"][0]["costs"] == {"time": 2.5, "preference": 3}


def test_each_task_is_done_alone_within_the_rules(run: Run, island: Path) -> None:
    rule = '[[rules]]\nname = "diet"\nformula = "G !fruit"\n'
    island.write_text(ISLAND + rule)
    result = run("check", "island.toml")
    warning = "task shop cannot be satisfied within the rules, not even alone; so that no plan exists"
    assert result.status == 3 and result.err == (
        f"prefplan: warning: tasks[0].formula: {warning}\nprefplan: every plan breaks the rule diet\n"
    )
    (island).write_text(ISLAND.replace('kind = "max"', 'kind = "max"\nover = "violation"') + rule + "skip = 3\n")
    assert run("check", "island.toml").status == 0


def test_memory_that_one_part_took_is_not_there_for_the_next() -> None:
    problem = loads(ISLAND).problem()
    limits = Limits(bytes=10**8)
    limits._in_use_before -= 2 * 10**8
    assert propositions.size_of(problem.system, limits)["states"] is None
    with pytest.raises(UnfinishedError, match="memory"):
        checkup._least_costs(problem, problem.tasks[0], limits, None)


def test_every_fault_of_a_scene_is_told_with_the_distance_that_is_enough(run: Run, tmp_path: Path) -> None:
    places = {"desk": "{ at = [0.5, 0.0] }", "tray": "{ at = [0.5, 0.04] }", "far": "{ at = [0.9, 0.3] }"}
    text = cup_scenario(places=places).replace('"desk" }', '"desk", size = [0.2] }')
    (tmp_path / "cell.toml").write_text(text)
    result = run("check", "cell.toml", "--json")
    assert (result.status, result.json["scene"]) == (2, False)
    assert result.err == "".join(f"prefplan: cell.toml: {fault}\n" for fault in result.json["faults"])
    size, apart = result.json["faults"]
    assert size.startswith("model.objects.cup.size: 0.2 m wide, but the hand grasps objects of 0.02 to")
    assert "model.locations.tray: 0.040 m from 'desk'" in apart and "at least 0." in apart
    text = text.replace("size = [0.2]", "size = [0.045]").replace("[0.5, 0.04]", f"[0.5, {apart.split()[-2]}]")
    (tmp_path / "cell.toml").write_text(text)
    result = run("check", "cell.toml")
    assert result.status == 0 and "out of reach by 5 cm" in result.out
    (tmp_path / "cell.toml").write_text(text.replace("0.9, 0.3", "0.75, 0.25"))
    assert "out of reach" not in run("check", "cell.toml").out


def test_a_robot_is_refused_for_a_model_without_an_arm(run: Run) -> None:
    assert_is_error(run("check", "rover", "--robot", "fetch"), "--robot: only for the arm of a manipulation model, and")


def test_what_the_arm_cannot_do_is_a_fault_only_if_a_task_needs_it(run: Run, tmp_path: Path) -> None:
    places = PLACES_NEARBY | {"far": "{ at = [0.81, 0.0] }"}
    wall = (
        '[model.fixtures]\nwall = { kind = "box", at = [0.9, 0.11, 0.02], size = [0.3, 0.02, 0.04] }\n[model.objects]'
    )
    text = cup_scenario(places=places).replace("[model.objects]", wall).replace("cup_tray", "cup_far")
    (tmp_path / "cell.toml").write_text(text)
    options = "cell.toml", "--robot", "panda_suction"
    result = run("check", *options)
    (row,) = [line.split(maxsplit=2) for line in result.out.splitlines() if line.startswith("cup")]
    assert result.status == 2 and "What the arm cannot do: 1 of 3 pairs" in result.out
    assert row[:2] == ["cup", "far"] and re.fullmatch(r"out of reach by \d cm", reason := row[2].strip())
    fault = f"tasks[0].formula: task tidy needs what the arm cannot do: cup at far ({reason})"
    assert result.err == f"prefplan: cell.toml: {fault}\n"
    quick = run("check", *options, "--quick", "--json")
    assert (quick.status, quick.json["scene"], quick.json["places"]) == (0, True, None)
    (tmp_path / "cell.toml").write_text(text.replace("cup_far", "cup_tray"))
    assert run("check", *options).status == 0


def test_a_task_is_a_fault_where_each_pair_can_be_done_but_no_plan(run: Run, tmp_path: Path) -> None:
    places = {"a": "{ at = [0.5, 0.2] }", "b": "{ at = [0.5, -0.2] }", "c": "{ at = [0.5, -0.245] }"}
    boxes = "\n".join(f'{{}} = {{{{ start = "{at}", kind = "box", size = [0.04, 0.04, 0.08] }}}}' for at in "ac")
    text = cup_scenario(places=places).replace('cup = { start = "desk" }', boxes.format("cup", "jar"))
    (tmp_path / "pair.toml").write_text(text.replace("cup_tray", "cup_b"))
    result, front = run("check", "pair.toml", "--json"), run("front", "pair.toml")
    (task,) = result.json["tasks"]
    assert (result.status, front.status, task["achievable"], task["costs"]) == (2, 3, False, None)
    assert result.err.startswith(
        "prefplan: pair.toml: tasks[0].formula: task tidy needs what the arm cannot do: cup at b"
    )
    (tmp_path / "pair.toml").write_text(text.replace("cup_tray", "cup_b").replace("-0.245", "-0.3"))
    assert run("check", "pair.toml").status == 0


def test_places_side_by_side_that_two_objects_do_not_fit_are_told(run: Run, tmp_path: Path) -> None:
    places = {"desk": "{ at = [0.45, -0.15] }", "tray": "{ at = [0.45, 0.15] }", "near": "{ at = [0.45, 0.22] }"}
    jar = 'cup = { start = "desk" }\njar = { start = "near", kind = "box", size = [0.06, 0.1, 0.05] }'
    (tmp_path / "pair.toml").write_text(cup_scenario(places=places).replace('cup = { start = "desk" }', jar))
    found = run("check", "pair.toml", "--json").json["places"]
    crowded = {(one["object"], one["location"]): one["crowded_by"] for one in found if one["crowded_by"]}
    assert crowded[("cup", "near")] == [{"object": "jar", "location": "tray"}]
    assert crowded[("jar", "tray")] == [{"object": "cup", "location": "near"}]
    assert all(one["put"] for one in found)


def test_all_that_case_study_3_may_ask_for_is_possible(run: Run) -> None:
    result = run("check", "case_study_3", "--json")
    assert (result.status, result.err, len(result.json["places"])) == (0, "", 21)
    for place in result.json["places"]:
        assert (place["take"], place["put"], place["reason"]) == (True, True, None)
        assert place["take_unless"] == place["put_unless"] == place["crowded_by"] == []
