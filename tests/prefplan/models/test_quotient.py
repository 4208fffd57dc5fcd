"""Searching the quotient of a manipulation model gives what searching all its states gives."""

from __future__ import annotations

import pickle
import random
from collections.abc import Callable
from dataclasses import replace

import pytest
from judge.planners import ListedPlanner
from random_manipulation import random_measured, random_model, random_problem, random_several
from small_models import COSTS, spot

from prefplan import (
    ManipulationModel,
    ModelError,
    NamedPreference,
    Object,
    Order,
    Planner,
    Problem,
    Task,
    best_plan,
    pareto_front,
)
from prefplan.heuristics import projection
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.symmetry import most_states

SEEDS = 12
"""Random problems of either kind."""


@pytest.mark.parametrize("seed", range(SEEDS))
def test_random_fronts_are_those_of_the_whole_model(seed: int) -> None:
    assert_bounded(random_model(random.Random(seed)))
    whole = pareto_front(random_problem(random.Random(seed)))
    again = random_problem(random.Random(seed), large=True)
    for planner in (Planner, ListedPlanner):
        front = planner(again).front()
        assert [(p.cost, p.preference) for p in front] == [(p.cost, p.preference) for p in whole]
        assert front.reason == whole.reason
        # Plans are checked action by action in the whole model when they are lifted to it.
        assert [len(plan.states) - 1 for plan in front] == [len(plan.actions) for plan in front]
        if whole:
            cheapest = planner(again).cheapest()
            assert (cheapest.cost, cheapest.preference) == (whole[0].cost, whole[0].preference)


def assert_bounded(model: ManipulationModel) -> None:
    """Fail if a model has more states than the bound of their number."""
    states = model.transition_system().listed.states
    assert len(states) <= most_states(model) * len({state.marks for state in states})


@pytest.mark.parametrize("seed", range(SEEDS))
def test_random_fronts_of_several_objectives_are_those_of_the_whole_model(seed: int) -> None:
    whole = pareto_front(random_several(random.Random(seed)))
    problem = random_several(random.Random(seed), large=True)
    front = (Planner if seed % 4 else ListedPlanner)(problem).front()
    assert [plan.objectives for plan in front] == [plan.objectives for plan in whole]
    assert front.reason == whole.reason
    for name in front.objectives:
        least = min((plan.objectives for plan in whole), key=lambda worth: (worth[name], *worth.values()))
        assert best_plan(problem, name).objectives == least


@pytest.mark.parametrize("draw", [random_problem, random_several])
@pytest.mark.parametrize("seed", range(4))
def test_random_fronts_with_measured_costs_are_those_of_the_whole_model(
    seed: int, draw: Callable[..., Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = random.Random(seed)
    assert_bounded(random_measured(rng, random_model(rng), "time"))
    whole = pareto_front(draw(random.Random(seed), measured=True))
    problem = draw(random.Random(seed), measured=True, large=True)
    # Places are merged in the bounds, or not.
    monkeypatch.setattr(projection, "APART_ENTRIES", seed % 2 * projection.APART_ENTRIES)
    front = (Planner if seed % 4 else ListedPlanner)(problem).front()
    assert [plan.objectives for plan in front] == [plan.objectives for plan in whole]
    assert front.reason == whole.reason


def test_plans_of_a_large_model_do_without_an_action_that_was_not_measured() -> None:
    objects = tuple(Object(f"o{k}", f"s{k}") for k in range(2))
    model = ManipulationModel(
        "home", COSTS, (spot("s0"), spot("s1"), spot("bin", capacity=2)), objects, listed_states=0
    )
    complete = random_measured(random.Random(0), model, "time").costs
    assert isinstance(complete, MeasuredCosts)
    direct, other = ("transport", "s0", "bin[0]"), ("transport", "s1", "bin[0]")
    for gaps, actions in (((direct,), 8), ((direct, other), 0)):
        entries = {pair: cost for pair, cost in complete.entries.items() if pair not in gaps}
        system = replace(model, costs=MeasuredCosts("time", entries)).transition_system()
        for planner in (Planner, ListedPlanner):
            front = planner(Problem(system, [Task("one", "F o0_bin")], Order())).front()
            assert [len(plan.actions) for plan in front] == [actions] * bool(actions)


def test_several_objectives_of_a_model_that_no_machine_can_list() -> None:
    costs = {kind: {"time": time, "energy": time**2} for kind, time in COSTS.items()}
    places = [*(spot(f"s{k}") for k in range(24)), spot("bin", capacity=4)]
    model = ManipulationModel("home", costs, tuple(places), tuple(Object(f"o{k}", f"s{k}") for k in range(20)))
    tasks = [Task("one", "F o0_bin"), Task("two", "F (o2_s9 & o3_bin)")]
    wishes = [NamedPreference("order", Order(("two", "one"))), NamedPreference("late", Order(), "energy")]
    front = pareto_front(Problem(model.transition_system(), tasks, wishes))
    assert front.complete and front.objectives == ("time", "energy", "order", "late")
    # Four objects are moved, for 3 + 1 + 5 + 1 and 9 + 1 + 25 + 1 each, in the one order or the other; or o2 waits in
    # the bin, so that it need not be fetched for the second task once the first is done.
    assert [tuple(plan.objectives.values()) for plan in front] == [(40, 144, 0, 36), (40, 144, 10, 0), (47, 171, 7, 0)]


def test_what_need_not_be_moved_costs_nothing() -> None:
    def states_searched(bystanders: int) -> int:
        places = [spot(f"s{k}") for k in range(4 + bystanders)] + [spot("bin", capacity=4)]
        objects = [Object(f"o{k}", f"s{k}") for k in range(4 + bystanders)]
        model = ManipulationModel("home", COSTS, tuple(places), tuple(objects), listed_states=0)
        tasks = [Task("one", "F (o0_bin & F o1_bin)"), Task("two", "F (o2_bin & o3_bin)")]
        planner = ListedPlanner(Problem(model.transition_system(), tasks, Order()))
        assert [(plan.cost, plan.preference) for plan in planner.front()] == [(40, 0)]
        assert planner._product is not None
        return planner._product.nodes

    assert states_searched(0) == states_searched(10)


def test_what_must_be_moved_first_because_its_location_must_be_empty_is_moved() -> None:
    places = spot("s0"), spot("s1"), spot("s2"), spot("bin", clear_of=("s0",))
    model = ManipulationModel("home", COSTS, places, (Object("o0", "s0"), Object("o1", "s1")), listed_states=0)
    for planner in (Planner, ListedPlanner):
        (plan,) = planner(Problem(model.transition_system(), [Task("one", "F o1_bin")], Order())).front()
        assert plan.cost == 20 and plan.actions[1] == "grasp o0"


def test_what_need_not_be_moved_is_where_carrying_it_costs_less_than_nothing_in_the_hand() -> None:
    costs = {kind: {"time": time, "energy": 1} for kind, time in COSTS.items()} | {"transit": {"time": 3, "energy": 9}}
    places = (*map(spot, ("shelf", "tray", "s0", "s1")), spot("desk", capacity=2))
    objects = (Object("box", "shelf"), Object("cup", "desk"))
    model = ManipulationModel("shelf", costs, places, objects, listed_states=0)
    front = pareto_front(Problem(model.transition_system(), {"t": "F cup_tray"}, ()))
    assert [(*plan.objectives.values(), plan.actions[0]) for plan in front] == [
        (10, 12, "transit desk"),
        (14, 6, "grasp box"),
    ]


def test_an_object_in_the_way_is_moved() -> None:
    objects = [Object("cup", "a"), Object("jug", "b"), Object("bowl", "c")]
    model = ManipulationModel("home", COSTS, tuple(map(spot, "abcd")), tuple(objects), listed_states=0)
    (plan,) = pareto_front(Problem(model.transition_system(), [Task("t", "F cup_b")], Order()))
    assert plan.actions[:4] == ("transit b", "grasp jug", "transport jug d", "release jug d")
    assert plan.actions[4:] == ("transit a", "grasp cup", "transport cup b", "release cup b")


def test_twenty_objects_whose_states_no_machine_word_holds() -> None:
    places = [*(spot(f"s{k}") for k in range(24)), spot("bin", capacity=4)]
    model = ManipulationModel("home", COSTS, tuple(places), tuple(Object(f"o{k}", f"s{k}") for k in range(20)))
    assert StateCodes(model, model.own_propositions).bound > 2**64
    tasks = [Task("one", "F (o0_bin & F o1_bin)"), Task("two", "F (o2_s9 & o3_bin)")]
    (plan,) = pareto_front(Problem(model.transition_system(), tasks, Order()))
    # Five objects are moved: the four, and what stands at s9.
    assert (plan.cost, plan.preference, len(plan.actions)) == (50, 0, 20)
    assert {action.split()[1] for action in plan.actions if action.startswith("grasp")} == {
        "o0",
        "o1",
        "o2",
        "o3",
        "o9",
    }
    with pytest.raises(ModelError, match="20 objects and 25 slots make more states than can be numbered"):
        _ = model.transition_system().listed
    # Where a hand travels for less with a load, what is not needed may yet be worth carrying.
    dear = replace(model, costs=COSTS | {"transit": 7})
    with pytest.raises(ModelError, match="20 objects and 25 slots make more states than can be numbered"):
        pareto_front(Problem(dear.transition_system(), tasks, Order()))


def test_a_model_that_another_process_gets_is_not_listed_either() -> None:
    places = [spot(f"s{k}") for k in range(16)]
    model = ManipulationModel("home", COSTS, tuple(places), tuple(Object(f"o{k}", f"s{k}") for k in range(12)))
    there = pickle.loads(pickle.dumps(model))
    assert there == model
    (plan,) = pareto_front(Problem(there.transition_system(), [Task("one", "F o0_s14")], Order()))
    assert (plan.cost, len(plan.actions)) == (10, 4)
