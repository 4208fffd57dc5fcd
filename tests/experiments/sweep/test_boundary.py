"""`prefplan sweep --find-boundary`: bisection over the amount of a perturbation, with made-up rollouts."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command_line import Run
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments.sweep import workers
from experiments.sweep.boundary import bisect, fails
from experiments.sweep.job import Sweep
from experiments.sweep.workers import Record


@pytest.mark.parametrize(
    ("holds", "boundary"),
    [
        (lambda amount: amount < 3.3, (3.125, 3.4375)),
        (lambda amount: True, (20, None)),
        (lambda amount: amount < 0.1, (0.0, 0.3125)),
        (lambda amount: False, (None, 0.0)),
    ],
)
def test_the_boundary_lies_between_two_amounts(holds: Callable[[float], bool], boundary: tuple[Any, Any]) -> None:
    tried: list[float] = []
    assert bisect(20, lambda amount: tried.append(amount) or holds(amount)) == boundary
    assert tried[0] == 20 and len(set(tried)) == len(tried) <= 8


def test_an_amount_fails_as_soon_as_the_threshold_is_out_of_reach() -> None:
    good, bad = ({"completed": completed} for completed in (True, False))
    assert not fails([good] * 37 + [bad] * 2, 40)
    assert fails([good, bad] * 3, 40), "with three failures of 40 it is below 95 %"


@pytest.fixture
def search(run: Run) -> Run:
    """Return a function that calls `prefplan sweep cup.toml`, for twelve rollouts."""
    return partial(run, "sweep", "cup.toml", "--rollouts", "12")


@pytest.fixture
def made_up(search: Run, monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """Make rollouts fail from a bias of 6 mm on; return those that were carried out."""
    Path("cup.toml").write_text(cup_scenario(places=PLACES_NEARBY))
    carried_out: list[tuple[str, int]] = []

    def rollouts(sweep: Sweep, numbers: list[int], *, jobs: int) -> Iterator[Record]:
        for number in numbers:
            carried_out.append((str(sweep.perturbation), number))
            record = sweep.failure(number, "too far", "too far")
            good = sweep.perturbation.bias < 0.006
            yield record | {"completed": good, "class": None if good else "too far"}

    monkeypatch.setattr(workers, "on_this_machine", rollouts)
    return carried_out


def test_the_search_writes_what_it_tried_and_does_nothing_twice(made_up: list[tuple[str, int]], search: Run) -> None:
    options = ("--find-boundary", "bias", "--perturb", "mass=0.1")
    status, out, err = search(*options)
    assert (status, err) == (0, "")
    assert "bias: completion falls below 95% between 5.9375 and 6.25 mm" in out
    assert "12 of 12 (100.0%)" in out and "0 of 10 (0.0%)" in out and "10 x too far" in out
    assert made_up[0] == ("mass=0.1,bias=20", 0) and len(made_up) == len(set(made_up))
    folder = Path("out", "cup", "boundary_cost_bias")
    assert (folder / "boundary.png").read_bytes().startswith(b"\x89PNG")

    before = len(made_up)
    status, out, _ = search(*options, "--json")
    result = json.loads(out)
    assert status == 0 and len(made_up) == before
    assert json.loads((folder / "boundary.json").read_text()) == result
    assert (result["boundary"], result["complete"], result["key"], result["unit"]) == (
        [5.9375, 6.25],
        True,
        "bias",
        "mm",
    )
    assert [trial["holds"] for trial in result["trials"]] == [trial["amount"] < 6 for trial in result["trials"]]
    assert result["perturb"] == "mass=0.1" and result["trials"][-1]["failures"] == [{"class": "too far", "count": 10}]

    status, out, _ = search("--find-boundary", "latency")
    assert "latency: completion stays at 95% or above up to the greatest latency, 200 ms" in out


def test_an_interrupted_search_keeps_what_is_finished_and_goes_on(
    made_up: list[tuple[str, int]], search: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    rollouts = workers.on_this_machine

    def interrupted(sweep: Sweep, numbers: list[int], **options: Any) -> Iterator[Record]:
        for record in rollouts(sweep, numbers, **options):
            yield record
            if len(made_up) == 22:
                raise KeyboardInterrupt

    monkeypatch.setattr(workers, "on_this_machine", interrupted)
    status, out, err = search("--find-boundary", "bias", "--json")
    result = json.loads(out)
    assert (status, err) == (130, "prefplan: interrupted; the same command continues it\n")
    assert (result["complete"], result["boundary"]) == (False, None)
    assert [(trial["amount"], trial["rollouts"], trial["holds"]) for trial in result["trials"]] == [
        (5, 2, None),
        (10, 10, False),
        (20, 10, False),
    ]
    assert search("--find-boundary", "bias")[0] == 0
    assert len(made_up) == len(set(made_up))


def test_a_key_that_is_none_is_refused(made_up: list[tuple[str, int]], search: Run) -> None:
    status, out, err = search("--find-boundary", "bais")
    assert (status, out, made_up) == (2, "", [])
    assert "--find-boundary: unknown name 'bais' (did you mean 'bias'?)" in err
    assert "--faults: unknown name 'slp' (did you mean 'slip'?)" in search("--faults", "slp")[2]
