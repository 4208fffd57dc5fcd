"""Plans that need only what an arm can do: it is asked for what plans need, and the front is that without the rest."""

from __future__ import annotations

import random
from collections.abc import Collection
from dataclasses import dataclass, replace

import pytest
from random_manipulation import enumerated, random_model, random_problem
from small_models import COSTS, spot

from prefplan import (
    ManipulationModel,
    NoPlanError,
    Object,
    Order,
    Planner,
    Problem,
    Task,
    UnfinishedError,
    WeightedSum,
)
from prefplan.errors import LimitError
from prefplan.limits import Limits
from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.symbolic import Barred, at, grasped_at
from prefplan.replanning import Past, continue_cheaply
from prefplan.search.driver import LabelSearch
from prefplan.search.labels import END


@dataclass(frozen=True)
class Told:
    barred: Barred = ()
    reason: str | None = "too far"
    location: str = ""


class Arm:
    """An arm that can do some things and not others, and remembers what it was asked.

    It cannot bring an object from a location to another where `indirect` has them, with propositions: while they hold.
    """

    def __init__(self, answers: dict[tuple[str, str], Told]) -> None:
        self.answers, self.transfers = answers, list[Transfer]()
        self.indirect: dict[tuple[str, str, str], frozenset[str]] = {}

    def rehearse(self, transfer: Transfer) -> Told | None:
        self.transfers.append(transfer)
        obj, source, target, others = transfer
        label = {at(*pair) for pair in others}
        steps = (source, f"grasp {obj}", label | {at(obj, source)}), (target, f"release {obj} {target}", label)
        for location, action, holding in steps:
            answer = self.answers.get((obj, location), Told())
            barred = [entry for entry in answer.barred if entry[1] == action and entry[0] <= holding]
            if barred:
                return replace(answer, barred=barred, location=location)
        if self.brings(obj, source, target, label):
            return None
        conditions = self.indirect[obj, source, target] | {grasped_at(obj, source)}
        return Told([(conditions, f"release {obj} {target}")], "directly", target)

    def brings(self, obj: str, source: str, location: str, label: Collection[str]) -> bool:
        return not self.indirect.get((obj, source, location), frozenset({"never"})) <= {*label}

    @property
    def barred(self) -> Barred:
        return [entry for answer in self.answers.values() for entry in answer.barred]


def cannot(obj: str, location: str, *while_there: str) -> Told:
    """An object that can be neither grasped at a location nor put there, while some propositions hold."""
    there = frozenset(while_there)
    return Told(((there | {at(obj, location)}, f"grasp {obj}"), (there, f"release {obj} {location}")))


def random_arm(rng: random.Random, problem: Problem, model: ManipulationModel) -> Arm:
    pairs = [(obj.name, place.name) for obj in model.objects for place in model.locations]
    lacking = rng.sample(pairs, rng.randint(1, len(pairs) // 2))
    beside = {pair: [at(*rng.choice(pairs))] if rng.random() < 0.4 else [] for pair in lacking}
    return Arm({pair: cannot(*pair, *beside[pair]) for pair in lacking})


def model_of(seed: int, *, large: bool) -> tuple[Problem, Arm]:
    problem = random_problem(random.Random(seed), large=large)
    return problem, random_arm(random.Random(seed), problem, random_model(random.Random(seed)))


def over(problem: Problem, arm: Arm | None, barred: Barred = ()) -> Problem:
    return Problem(
        problem.system.without(barred), problem.tasks, problem.preferences, rules=problem.rules, feasible=arm
    )


@pytest.mark.slow
@pytest.mark.parametrize("large", [False, True])
def test_asking_only_for_what_plans_need_finds_the_front_of_all_that_the_arm_can_do(large: bool) -> None:
    repaired = 0
    for seed in range(30):
        problem, arm = model_of(seed, large=large)
        expected = Planner(over(problem, None, arm.barred)).front()
        planner = Planner(over(problem, arm))
        front = planner.front()
        assert [plan.objectives for plan in front] == [plan.objectives for plan in expected]
        assert front.reason == expected.reason or (front.reason and expected.reason)
        assert len(arm.transfers) == len(set(arm.transfers))
        if front:
            best = Planner(over(problem, arm)).cheapest()
            assert best.objectives == front[0].objectives
        assert planner.geometry is not None
        repaired += bool(planner.geometry.left_out)
    assert repaired >= 5


@pytest.mark.slow
@pytest.mark.parametrize("large", [False, True])
def test_fronts_of_objects_that_must_not_go_directly_are_the_enumerated_ones(large: bool) -> None:
    indirect = 0
    for seed in range(40):
        rng, problem = random.Random(seed), random_problem(random.Random(seed), large=large)
        model = random_model(random.Random(seed))
        arm = random_arm(rng, problem, model) if rng.random() < 0.5 else Arm({})
        for obj in model.objects:
            for _ in range(3):
                source, location = rng.sample([place.name for place in model.locations], 2)
                pairs = [(other.name, place.name) for other in model.objects for place in model.locations]
                for origin in sorted({obj.start, source} - {location}):
                    beside = [at(*rng.choice(pairs))] if rng.random() < 0.2 else []
                    arm.indirect[obj.name, origin, location] = frozenset(beside)

        barred = arm.barred

        def exists(action: str, origin: str, label: frozenset[str], arm: Arm = arm, barred: Barred = barred) -> bool:
            if any(name == action and conditions <= label for conditions, name in barred):
                return False
            kind, obj, *location = action.split()
            return kind != "release" or arm.brings(obj, origin, *location, label)

        listed = Problem(enumerated(model, exists), problem.tasks, problem.preferences, rules=problem.rules)
        expected = Planner(listed).front()
        planner = Planner(over(problem, arm))
        front = planner.front()
        assert [plan.objectives for plan in front] == [plan.objectives for plan in expected], seed
        assert front.reason == expected.reason or (front.reason and expected.reason)
        assert planner.geometry is not None and (not front or all(map(planner.geometry.holds, front)))
        indirect += any("directly" in reason for reason in planner.geometry.left_out.values())
    assert indirect >= 10


def test_an_object_goes_by_way_of_another_location_and_no_rule_is_blamed_if_there_is_none() -> None:
    arm = Arm({})
    arm.indirect["cup", "s0", "far"] = frozenset()
    front = Planner(Problem(MODEL, {"t": "F cup_far"}, Order(), feasible=arm)).front()
    assert [plan.cost for plan in front] == [17]
    said = "The arm cannot do cup at far (directly). If it could: cost 10, preference 0."
    assert front.assumptions[-1] == said
    others = [place.name for place in PLACES if place.name not in ("s0", "far")]
    arm.answers |= {("cup", place): cannot("cup", place) for place in others}
    with pytest.raises(NoPlanError, match="task t can never be satisfied"):
        Planner(Problem(MODEL, {"t": "F cup_far"}, Order(), feasible=arm)).cheapest()


def test_an_object_goes_by_way_of_another_location_however_many_transfers_are_impossible() -> None:
    places = [spot(f"p{k}") for k in range(20)]
    model = ManipulationModel("home", COSTS, tuple(places), (Object("cup", "p0"), Object("jug", "p19")))
    arm = Arm({})
    arm.indirect = {("cup", "p0", f"p{k}"): frozenset() for k in range(1, 18)}
    goal = " | ".join(f"cup_p{k}" for k in range(1, 18))
    planner = Planner(Problem(model, {"t": f"F ({goal})"}, Order(), feasible=arm))
    front = planner.front()
    assert [plan.cost for plan in front] == [17] and "transport cup p18" in front[0].actions


PLACES = (*(spot(f"s{k}") for k in range(3)), spot("near", capacity=2), spot("far"))
MODEL = ManipulationModel("home", COSTS, PLACES, (Object("cup", "s0"), Object("jug", "s1")))
EITHER = {"served": "F (cup_far | jug_far | (cup_near & jug_near))"}


def test_what_was_left_out_and_its_price_are_named() -> None:
    arm = Arm({("cup", "far"): cannot("cup", "far"), ("jug", "far"): cannot("jug", "far")})
    front = Planner(Problem(MODEL, EITHER, Order(), feasible=arm)).front()
    assert [plan.cost for plan in front] == [20]
    assert [note for note in front.assumptions if "arm" in note] == [
        "The arm cannot do cup at far (too far); jug at far (too far). If it could: cost 10, preference 0."
    ]
    assert {(transfer.obj, transfer.target) for transfer in arm.transfers} >= {
        ("cup", "far"),
        ("jug", "far"),
        ("jug", "near"),
    }


def test_only_the_plans_that_are_lost_are_named() -> None:
    tasks = [Task("t", "F cup_far", skip=5)]
    weighed = WeightedSum({"t": 1}, over="violation")
    arm = Arm({("cup", "far"): cannot("cup", "far")})
    front = Planner(Problem(MODEL, tasks, weighed, feasible=arm)).front()
    assert [plan.cost for plan in front] == [0]
    assert front.assumptions[-1] == "The arm cannot do cup at far (too far). If it could: cost 10, preference 0."


def test_what_was_left_out_may_cost_nothing() -> None:
    arm = Arm({("cup", "far"): cannot("cup", "far")})
    front = Planner(Problem(MODEL, {"t": "F (cup_far | jug_far)"}, Order(), feasible=arm)).front()
    assert [plan.cost for plan in front] == [10]
    assert front.assumptions[-1] == "The arm cannot do cup at far (too far). Other plans are as good."


def test_a_conflict_of_two_objects_is_told_once_and_in_words() -> None:
    answers = {("cup", "s2"): cannot("cup", "s2", "jug_far"), ("jug", "far"): cannot("jug", "far", "cup_s2")}
    arm = Arm({pair: replace(answer, reason=None) for pair, answer in answers.items()})
    problem = Problem(
        MODEL, {"laid": "F (cup_s2 & jug_far) | F (cup_near & jug_near & F cup_s0)"}, Order(), feasible=arm
    )
    planner = Planner(problem)
    planner.cheapest()
    assert planner.geometry is not None
    assert str(planner.geometry.note).startswith(
        "The arm cannot do cup at s2 (no room beside jug at far). If it could: "
    )


def test_a_front_that_the_arm_can_carry_out_names_nothing() -> None:
    planner = Planner(Problem(MODEL, EITHER, Order(), feasible=Arm({})))
    front = planner.front()
    assert front.assumptions == () and list(front) == list(Planner(Problem(MODEL, EITHER, Order())).front())
    assert planner.geometry is not None and planner.geometry.note is None


def test_no_plan_is_left() -> None:
    arm = Arm({("cup", "far"): cannot("cup", "far")})
    planner = Planner(Problem(MODEL, {"t": "F cup_far"}, Order(), feasible=arm))
    with pytest.raises(NoPlanError, match="task t can never be satisfied"):
        planner.cheapest()
    assert planner.geometry is not None
    assert planner.geometry.left_out == {("cup", "far"): "too far"}


def test_a_problem_says_whether_it_is_abstract() -> None:
    assert "abstract=True" in repr(Problem(MODEL, EITHER, Order()))
    assert "abstract=False" in repr(Problem(MODEL, EITHER, Order(), feasible=Arm({})))


def test_what_was_done_already_is_not_asked_for() -> None:
    arm = Arm({("cup", "s0"): cannot("cup", "s0")})
    problem = Problem(MODEL, {"t": "F cup_far"}, Order(), feasible=arm)
    system = problem.system
    states = [system.start]
    for action in ("transit s0", "grasp cup"):
        states.append(system.steps(states[-1], action)[0])
    past = Past(("transit s0", "grasp cup"), (1, 2), tuple(map(system.decode, states[:2])), (frozenset(), frozenset()))
    here = replace(MODEL, begin=system.decode(states[2]))  # type: ignore[arg-type]
    plan = continue_cheaply(problem, past, here.transition_system())
    assert plan.actions[2:] == ("transport cup far", "release cup far") and [
        transfer[:3] for transfer in arm.transfers
    ] == [("cup", "s0", "far")]


class Slow(Arm):
    """An arm whose answers take longer than a limit."""

    def rehearse(self, transfer: Transfer) -> Told | None:
        if self.transfers:
            raise LimitError("time")
        return super().rehearse(transfer)


def test_a_transfer_that_was_found_impossible_when_a_limit_was_reached_stays_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arm = Arm({})
    arm.indirect |= {("cup", "s0", "far"): frozenset(), ("jug", "s1", "far"): frozenset()}
    planner = Planner(Problem(MODEL, {"t": "F (cup_far & jug_far) | F (cup_far & jug_near)"}, Order(), feasible=arm))
    rehearse = arm.rehearse

    def slow(transfer: Transfer) -> Told | None:
        if len(arm.transfers) == 1:
            arm.transfers.append(transfer)
            raise LimitError("time")
        return rehearse(transfer)

    monkeypatch.setattr(arm, "rehearse", slow)
    assert planner.front().ended == "time" and arm.transfers[0].obj == "cup"
    front = planner.front()
    assert front.ended is None and [plan.cost for plan in front] == [27]


def test_a_limit_while_the_arm_is_asked_leaves_no_plan_that_it_may_be_unable_to_carry_out() -> None:
    front = Planner(Problem(MODEL, {"t": "F (cup_far & jug_s2)"}, Order(), feasible=Slow({}))).front()
    assert (len(front), front.ended, front.reason) == (0, "time", None)
    known = Slow({("cup", "s0"): cannot("cup", "s0")})
    assert Planner(Problem(MODEL, EITHER, Order(), feasible=known)).front().assumptions == (
        "The arm cannot do cup at s0 (too far). If it could: cost 10, preference 0.",
    )
    with pytest.raises(UnfinishedError, match="time limit"):
        Planner(Problem(MODEL, {"t": "F (cup_far & jug_s2)"}, Order(), feasible=Slow({}))).cheapest()


def test_a_plan_that_a_limit_leaves_is_not_given_before_the_arm_was_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    run, ends = LabelSearch._run, list[int]()

    def noted(self: LabelSearch, pops: int) -> int:
        ends.append(run(self, min(pops, 1)))
        return ends[-1]

    monkeypatch.setattr(LabelSearch, "_run", noted)
    monkeypatch.setattr(Limits, "out_of_time", property(lambda self: END.GOALS in ends))
    left = []
    for arm in (None, Arm({})):
        ends.clear()
        with pytest.raises(UnfinishedError) as caught:
            Planner(Problem(MODEL, EITHER, Order(), feasible=arm)).cheapest(max_seconds=600)
        left.append(caught.value.best is not None)
    assert left == [True, False]
