"""Fronts of manipulation models in which some actions do not exist in some states, against an enumeration."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from judge.planners import ListedPlanner
from random_manipulation import enumerated, random_problem, random_several
from small_models import COSTS, measured, spot

from prefplan import ManipulationModel, ModelError, Object, Order, Planner, Problem, Reason, Task
from prefplan.models.manipulation.symbolic import Barred, ManipulationState, grasped_at
from prefplan.models.manipulation.symmetry import Symmetry
from prefplan.models.manipulation.system import ManipulationSystem

SEEDS = 60
"""Random models of the first kind; a quarter as many of the second."""


def random_barred(rng: random.Random, model: ManipulationModel) -> Barred:
    """Draw exclusions, many of them the same for several objects or locations, some only while something holds.

    Some are of objects that were grasped at a location.
    """
    objects, places = [obj.name for obj in model.objects], [place.name for place in model.locations]
    barred: list[tuple[frozenset[str], str]] = []
    for _ in range(rng.randint(1, 4)):
        chosen = rng.sample(objects, rng.randint(1, len(objects)))
        there = rng.sample(places, rng.choice((1, 1, 2)))
        kind, other = rng.choice(("grasp", "transport", "release", "release", "transit")), rng.choice(objects)
        condition = rng.choice(("", "", f"{other}_{rng.choice(places)}", f"holding_{other}", f"{other}_wet"))
        conditions = frozenset({condition} - {""})
        origins = rng.sample(places, rng.randint(1, 2)) if rng.random() < 0.4 else []
        for place in there:
            for obj in chosen:
                if kind in ("transport", "release") and origins:
                    action = f"{kind} {obj} {place}"
                    barred += [(conditions | {grasped_at(obj, origin)}, action) for origin in origins]
                elif kind == "grasp":
                    barred.append((conditions | {f"{obj}_{place}"}, f"grasp {obj}"))
                else:
                    barred.append((conditions, f"transit {place}" if kind == "transit" else f"{kind} {obj} {place}"))
    return barred


def over(problem: Problem, system: object) -> Problem:
    return Problem(system, problem.tasks, problem.preferences, rules=problem.rules)  # type: ignore[arg-type]


def compared(draw: Callable[..., Problem], seed: int, *, measured: bool) -> bool:
    """Fail unless all fronts of a random problem are the enumerated one; return whether exclusions changed it."""
    listed = draw(random.Random(seed), measured=measured)
    large = draw(random.Random(seed), measured=measured, large=True)
    assert isinstance(large.system, ManipulationSystem)
    barred = random_barred(random.Random(seed), large.system.space.model)

    def exists(action: str, origin: str, label: frozenset[str]) -> bool:
        told = label | {grasped_at(action.split()[1], origin)}
        return not any(name == action and conditions <= told for conditions, name in barred)

    expected = Planner(over(listed, enumerated(large.system.space.model, exists))).front()
    points = [tuple(plan.objectives.values()) for plan in expected]
    fewer = large.system.without(barred)
    for planner, system in ((Planner, fewer), (ListedPlanner, fewer), (Planner, listed.system.without(barred))):
        front = planner(over(listed, system)).front()
        assert [tuple(plan.objectives.values()) for plan in front] == points
        assert front.reason == expected.reason
        for plan in front:
            # Each plan is one of the whole model without the excluded actions, with these costs.
            _, states, _, costs = fewer.trajectory(plan.actions)
            assert [sum(each) for each in costs] == [plan.objectives[name] for name in fewer.cost_names]
            told = [state.conditions for state in states if isinstance(state, ManipulationState)]
            steps = zip(told, plan.actions, strict=False)
            assert not any(name == action and held <= label for label, action in steps for held, name in barred)
    return points != [tuple(plan.objectives.values()) for plan in Planner(listed).front()]


@pytest.mark.slow
def test_random_fronts_without_some_actions_are_the_enumerated_ones() -> None:
    changed = [compared(random_problem, seed, measured=seed % 4 == 3) for seed in range(SEEDS)]
    assert sum(changed) >= SEEDS // 10


@pytest.mark.slow
def test_random_fronts_of_several_objectives_without_some_actions_are_the_enumerated_ones() -> None:
    changed = [compared(random_several, seed, measured=seed % 4 == 3) for seed in range(SEEDS // 4)]
    assert any(changed)


def model_of(places: int, objects: int) -> ManipulationModel:
    spots = (*(spot(f"s{k}") for k in range(places)), spot("bin", capacity=2))
    return ManipulationModel(
        "home", COSTS, spots, tuple(Object(f"o{k}", f"s{k}") for k in range(objects)), listed_states=0
    )


@pytest.mark.parametrize(
    ("condition", "action"),
    [({"holding_o0"}, "release o0 bin"), (set[str](), "release o0 bin"), ({"o0_s0"}, "grasp o0")],
)
def test_a_task_that_exclusions_make_impossible_needs_no_search(condition: set[str], action: str) -> None:
    system = model_of(14, 10).transition_system().without([(frozenset(condition), action)])
    problem = Problem(system, [Task("a", "F o0_bin"), Task("b", "F (o1_bin & o2_s1 & o3_s2 & o4_s3 & o5_s4)")], Order())
    front = Planner(problem).front(max_memory=1e9)
    assert front.complete and not list(front) and front.reason == Reason("task", ("a",))


def test_objects_and_locations_stay_alike_where_the_same_is_excluded() -> None:
    model = model_of(6, 4)
    everywhere = [(frozenset[str](), f"release {obj} {place}") for obj in ("o2", "o3") for place in ("s4", "s5")]
    symmetry = Symmetry(model, {"o0_bin"}, everywhere)
    assert symmetry.alike == (("o1",), ("o2", "o3"))
    assert symmetry.neutral == (("s0", "s1", "s2", "s3"), ("s4", "s5"))
    beside = [(frozenset({"o1_s1", "o2_s2"}), "grasp o1")]
    assert Symmetry(model, {"o0_bin"}, beside).alike == (("o1",), ("o2",), ("o3",))
    assert Symmetry(model, {"o0_bin"}, [(frozenset({"o9_s1"}), "grasp o1")]).alike == (("o1", "o2", "o3"),)


def test_an_object_that_need_not_be_moved_is_left_out_unless_an_exclusion_depends_on_it() -> None:
    system = model_of(9, 4).transition_system()
    assert isinstance(system, ManipulationSystem)
    kept = [
        system.without(barred).reduced({"o0_bin"}, stutter_invariant=True).space.objects
        for barred in ([(frozenset({"o1_s1"}), "grasp o1")], [(frozenset({"o1_s1"}), "release o0 bin")])
    ]
    assert kept == [["o0"], ["o0", "o1"]]


def test_a_plan_moves_first_what_stands_in_the_way() -> None:
    system = model_of(4, 2).transition_system()
    fewer = system.without([(frozenset({"o1_s1"}), "release o0 bin"), (frozenset(), "transport o1 s2")])
    (plan,) = Planner(Problem(fewer, [Task("t", "F o0_bin")], Order())).front()
    assert plan.cost == 2 * (COSTS["transit"] + COSTS["grasp"] + COSTS["transport"] + COSTS["release"])
    assert "release o1 s2" not in plan.actions and plan.actions[-1] == "release o0 bin"


def test_what_is_excluded_at_a_location_is_so_in_each_of_its_slots() -> None:
    spots = spot("s0"), spot("bin", capacity=2)
    model = ManipulationModel("home", COSTS, spots, (Object("o0", "bin"), Object("o1", "bin")), listed_states=0)
    system = measured(model).transition_system()  # measured costs tell slots apart
    fewer = system.without([(frozenset({f"{obj}_bin"}), f"grasp {obj}") for obj in ("o0", "o1")])
    for obj in ("o0", "o1"):
        problem = Problem(system, [Task("t", f"F {obj}_s0")], Order())
        assert Planner(problem).front() and not Planner(over(problem, fewer)).front()


def test_an_exclusion_that_is_no_action_is_refused() -> None:
    system = model_of(2, 1).transition_system()
    with pytest.raises(ModelError, match="unknown action 'fly'"):
        system.without([(frozenset(), "fly o0")])
