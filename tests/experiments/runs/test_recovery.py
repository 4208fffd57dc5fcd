"""Mismatches from which a run recovers: fallen objects that it does not need, crooked towers, walls, late motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scenario_texts import task_tables

from experiments import scenarios
from experiments.runs.evidence import evidence
from experiments.runs.outcome import Outcome
from experiments.runs.run_plan import run_plan, scene_of
from prefplan import ManipulationModel, Scenario, load, pareto_front
from sim.evidence.certificate import certify
from sim.execution.faults import move
from sim.execution.faults.fault import read_fault
from sim.simulation.run import FRAME_RATE_HZ

REST_SPEED_M_S = 0.01

HEAD = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
"""

BYSTANDER = """
[model.locations]
a = { at = [0.42, -0.12] }
v = { at = [0.60, -0.28] }
bin = { at = [0.42, 0.36], kind = "bin" }
[model.objects]
x = { start = "a" }
vase = { start = "v", kind = "cylinder", size = [0.045, 0.06] }
""" + task_tables(tidy="F x_bin", preference="")

TOWER = """
[model.locations]
base = { at = [0.4532, -0.2113] }
goal = { at = [0.4532, 0.2113] }
buf = { at = [0.42, 0.0] }
b1 = { on = ["base"] }
b2 = { on = ["b1"] }
g1 = { on = ["goal"] }
g2 = { on = ["g1"] }
[model.objects]
p = { start = "base" }
q = { start = "b1" }
r = { start = "b2" }
""" + task_tables(turn="F (r_goal & q_g1 & p_g2)", preference="")

TALL = """
[model.locations]
desk = { at = [0.45, 0.15] }
side = { at = [0.55, -0.20] }
tray = { at = [0.50, 0.0] }
bin = { at = [0.35, -0.32], kind = "bin", capacity = 2 }
[model.objects]
can = { start = "desk", kind = "cylinder", size = [0.055, 0.10] }
pack = { start = "side", kind = "box", size = [0.05, 0.04, 0.09] }
""" + task_tables(can="F can_tray", pack="F pack_bin", preference="")

HIGH_CAN = """
[model.locations]
desk = { at = [0.45, 0.15] }
side = { at = [0.55, -0.20] }
tray = { at = [0.50, 0.0] }
[model.objects]
can = { start = "desk", kind = "cylinder", size = [0.055, 0.10] }
box = { start = "side", kind = "box", size = [0.05, 0.04, 0.09] }
""" + task_tables(can="F can_tray", preference="")

PLANK = """
[model.locations]
l = { at = [0.5, 0.04] }
r = { at = [0.5, -0.04] }
top = { on = ["l", "r"] }
p = { at = [0.3182, 0.3182] }
q = { at = [0.3182, -0.3182] }
s = { at = [0.5196, 0.3] }
[model.objects]
a = { start = "p" }
b = { start = "q" }
plank = { start = "s", kind = "box", size = [0.045, 0.1, 0.03] }
""" + task_tables(bridge="F (a_l & b_r & plank_top)", preference="")

CAN = """
[model.locations]
a = { at = [0.42, -0.22] }
d = { at = [0.5, 0.22], kind = "plate" }
[model.objects]
x = { start = "a", kind = "cylinder", size = [0.06, 0.03] }
""" + task_tables(serve="F x_d", preference="")

WALL = """
[model.fixtures]
wall = { kind = "box", at = [0.48, 0.02, 0.06], size = [0.20, 0.02, 0.12] }
[model.locations]
side = { at = [0.58, 0.20] }
dish = { at = [0.45, -0.15], kind = "plate" }
[model.objects]
carton = { start = "side", kind = "box", size = [0.045, 0.035, 0.085] }
[[tasks]]
name = "carton"
formula = "F carton_dish"
"""

SUPPER = """
[model.locations]
stove = { at = [0.5, -0.15], marks = "cooked", kind = "stove" }
shelf = { at = [0.55, 0.30] }
plate = { at = [0.45, 0.15], kind = "plate" }
[model.objects]
fish = { start = "stove" }
soup = { start = "shelf" }
[[tasks]]
name = "fish"
formula = "F fish_cooked"
[[tasks]]
name = "soup"
formula = "F (fish_cooked & X F soup_plate)"
"""

TAIL = """
[preference]
kind = "order"
"""

Recover = Callable[..., Outcome]


@pytest.fixture
def recover(tmp_path: Path) -> Recover:
    """Return a function that carries out the cheapest plan for a scene while faults happen, and certifies it."""

    def run(scene: str, *faults: str, seed: int) -> Outcome:
        if scene in scenarios.names():
            scenario: Scenario = load(scene)
        else:
            (tmp_path / "scene.toml").write_text(HEAD + scene + TAIL)
            scenario = load(tmp_path / "scene.toml")
        assert isinstance(scenario.model, ManipulationModel)
        read = [read_fault(text, scenario.model) for text in faults]
        built = scene_of(scenario, faults=read)
        outcome = run_plan(scenario, built, pareto_front(scenario.problem())[0], seed=seed, faults=read)
        certificate = certify(evidence(outcome))
        assert certificate.confirmed, certificate.refuted
        return outcome

    return run


def final_speed(outcome: Outcome, first: int) -> float:
    """Return the final speed, m/s, of the object whose position begins at this column of the recorded states."""
    last = outcome.run.qpos[-2:, first : first + 3]
    return float(np.linalg.norm(np.diff(last, axis=0))) * FRAME_RATE_HZ


def test_an_unknown_object_where_there_is_no_room_for_it_ends_no_run_with_an_error(recover: Recover) -> None:
    outcome = recover("shelf", "move:rice@8", "foreign:low@2", seed=3076574810)
    assert "tea" in outcome.ledger.final.satisfied and all(time is not None for _, time in outcome.faults)


def test_what_fell_over_and_no_task_mentions_stops_nothing(recover: Recover) -> None:
    outcome = recover(BYSTANDER, "knock:vase@1", seed=1)
    assert outcome.run.completed, outcome.run.reason
    assert (outcome.run.replans, len(outcome.executed)) == (0, 4)
    assert "vase" in str([event.detail for event in outcome.run.events if event.kind == "unaffected"])


@pytest.mark.parametrize("seed", [4, 24])
def test_what_lies_beside_a_wall_is_put_down_by_a_hand_that_is_clear_of_it(recover: Recover, seed: int) -> None:
    assert recover(WALL, "knock:carton@1", seed=seed).completed


def test_what_was_marked_and_fell_from_the_table_is_not_in_the_way_of_other_tasks(
    recover: Recover, monkeypatch: pytest.MonkeyPatch
) -> None:
    # It falls from where it is put.
    monkeypatch.setattr(move, "is_carried", lambda *place: True)
    outcome = recover(SUPPER, "move:fish@5", seed=3)
    assert outcome.completed and outcome.executed[-1] == "release soup plate"
    assert "fish_cooked" not in outcome.run.steps[-1].observed.label


def test_what_is_higher_than_the_fingers_are_long_is_taken_near_its_top_and_set_upright(recover: Recover) -> None:
    assert recover(TALL, "knock:can@2", seed=3).completed


def test_success_is_judged_by_the_tasks(recover: Recover) -> None:
    outcome = recover(TALL, "knock:can@8", seed=3)
    assert outcome.run.completed, outcome.run.reason
    assert len(outcome.executed) == 8 and outcome.ledger.final.satisfied == {"can", "pack"}


@pytest.mark.parametrize(
    ("seed", "faults"),
    [
        # The hand is still round the can's top when it has risen by 5 cm from its middle.
        pytest.param(4245214700, ["knock:can@3"], id="knocked over as the hand leaves it"),
        # Its top brushes a finger between two frames; no frame shows this until it lies.
        pytest.param(1596810411, ["slip@4", "blind:1.8@4"], id="slips unseen"),
    ],
)
def test_a_high_can_is_put_down_in_the_end_and_the_log_is_honest(
    recover: Recover, seed: int, faults: list[str]
) -> None:
    outcome = recover(HIGH_CAN, *faults, seed=seed)
    assert outcome.run.completed and all(time is not None for _, time in outcome.faults)


@pytest.mark.parametrize("seed", [7, 9])
def test_a_tower_is_built_on_what_stands_there(recover: Recover, seed: int) -> None:
    outcome = recover(TOWER, "knock:r@12", seed=seed)
    assert outcome.run.completed, outcome.run.reason
    assert outcome.run.replans <= 1


def test_a_block_against_a_wall_is_taken(recover: Recover) -> None:
    outcome = recover("case_study_3", "move:blue@14", seed=0)
    assert outcome.run.completed, outcome.run.reason


def test_a_plank_is_laid_on_two_blocks(recover: Recover) -> None:
    outcome = recover(PLANK, seed=0)
    assert outcome.run.completed, outcome.run.reason


@pytest.mark.parametrize("seed", [1, 41])
def test_nothing_moves_when_a_run_is_completed(recover: Recover, seed: int) -> None:
    outcome = recover(CAN, "knock:x@4", seed=seed)
    assert outcome.run.completed, outcome.run.reason
    assert final_speed(outcome, outcome.run.qpos.shape[1] - 7) < REST_SPEED_M_S


@pytest.mark.parametrize(
    ("scenario", "seed", "faults"),
    [
        # It slips while nothing is seen,
        ("case_study_3", 1220005862, ("move:blue@11", "blind:2.2@3", "slip@3")),
        # while it is lowered, and would be pressed onto the table,
        ("case_study_3", 2097067815, ("slip@11", "knock:blue@10")),
        # as the hand begins the next action before it has arrived,
        ("case_study_3", 3777058066, ("knock:pink@13", "slip@12")),
        # and until it hangs at the tips of the pads, and is taken along by them for a while.
        ("shelf", 3809678986, ("slip@7", "miss:1@3", "blind:2.8@12")),
    ],
)
def test_what_slips_is_noticed_in_time_and_the_log_proves_it(
    recover: Recover, scenario: str, seed: int, faults: tuple[str, ...]
) -> None:
    outcome = recover(scenario, *faults, seed=seed)
    assert outcome.run.completed, outcome.run.reason
