"""A fault of one's own, from outside: one class, from the command line to the log, and its name for the certificate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command_line import assert_is_error, call
from scenario_texts import CUP

import prefplan as pp
import sim
from experiments.sweep.faults import random_faults
from prefplan.scenario.decode import loads
from sim.evidence.fault_checks import FAULT_KINDS
from sim.execution.faults import fault
from sim.execution.faults.fault import Injection


@pytest.fixture(autouse=True)
def lag() -> Iterator[None]:
    """Define a kind of fault; as all tests of a process share them, it is forgotten at the end."""

    class Lag(sim.Fault):
        """The fingers move later, once the run has taken half a second."""

        kind, noun = "lag", "PERIODS"

        @classmethod
        def candidates(cls, model: pp.ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
            return [str(rng.integers(1, 5))]

        def objection(self, model: pp.ManipulationModel) -> str | None:
            return None if self.argument.isdecimal() else f"{self.argument!r} is no number"

        def unavailable_because(self, model: pp.ManipulationModel) -> str | None:
            return "it is too long" if int(self.argument) > 9 else None

        def inject(self, injection: Injection) -> dict[str, str] | None:
            cell = injection.cell
            if cell.data.time < 0.5:
                return None
            sent, hold = [cell.width] * int(self.argument), cell.gripper
            cell.gripper = lambda width: (sent.append(width), hold(sent.pop(0)))[1]
            return {"periods": self.argument}

    FAULT_KINDS.add("lag")
    yield
    FAULT_KINDS.remove("lag")
    del fault._KINDS["lag"]


def test_a_fault_from_outside_goes_from_the_command_line_to_the_log(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("cup.toml").write_text(CUP)
    run = partial(call, capsys)
    assert "lag:PERIODS@K" in run("run", "--help").out and "lag:PERIODS@K" in run("sweep", "--help").out
    assert_is_error(run("run", "cup.toml", "--fault", "lag:x@1"), "prefplan: --fault 'lag:x@1': 'x' is no number")
    refused = run("run", "cup.toml", "--fault", "lag:10@1")
    assert_is_error(refused, "prefplan: --fault 'lag:10@1': cannot happen: it is too long")
    result = run("run", "cup.toml", "--no-video", "--json", "--out", "out", "--fault", "lag:3@1")
    assert result.status == 0, result.err
    (fault,) = result.json["faults"]
    assert fault["fault"] == "lag:3@1" and 0.5 <= fault["time"] < 0.6
    (log,) = Path("out").glob("*.npz")
    events = [event.detail for event in sim.read_log(log).about.events if event.kind == "fault"]
    assert events == [{"fault": "lag:3@1", "periods": "3"}]


def test_a_fault_from_outside_is_drawn_in_sweeps() -> None:
    model = loads(CUP).model
    assert isinstance(model, pp.ManipulationModel)
    drawn = [random_faults(model, 4, seed=seed, kind="lag")[0] for seed in range(30)]
    assert {fault.argument for fault in drawn} == {"1", "2", "3", "4"}
    assert "lag" in {fault.kind for seed in range(60) for fault in random_faults(model, 4, seed=seed, kind="random")}
