"""The results of all scenarios, with made-up rollouts."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from experiments.sweep import results, workers
from experiments.sweep.job import Record, Sweep, failure
from sim.execution.faults import SPELLINGS
from sim.world.randomization import KEYS


def test_the_results_tell_completion_faults_and_boundaries_and_go_on_where_they_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    carried_out = []

    def rollouts(sweep: Sweep, numbers: Sequence[int], **options: Any) -> Iterator[Record]:
        for number in numbers:
            carried_out.append((sweep.folder, number))
            if len(carried_out) == 5:
                raise KeyboardInterrupt
            good = sweep.perturbation.bias < 0.003 and not (sweep.faults == "knock" and number == 0)
            told = {"completed": good, "class": None if good else "the log refutes it"}
            happened = [sweep.faults] if sweep.faults and number < 2 else []
            yield failure(sweep, number, "", "") | told | {"happened": happened}

    monkeypatch.setattr(workers, "on_this_machine", rollouts)
    command = ["--rollouts", "3", "--scenario", "case_study_3", "--quiet"]
    command += ["--out", str(tmp_path / "records"), "--into", str(tmp_path / "results")]
    assert results.main(command) == 130
    assert "the same command goes on" in capsys.readouterr().err and not (tmp_path / "results").exists()
    assert results.main(command) == 0
    assert len(set(carried_out)) == len(carried_out) - 1, "only the interrupted one is carried out again"

    page, found = (
        (tmp_path / "results" / "sweeps.md").read_text(),
        json.loads((tmp_path / "results" / "sweeps.json").read_text()),
    )
    assert page in capsys.readouterr().out
    assert [(row["plan"], row["completed"], row["rollouts"]) for row in found["plain"]] == [
        ("cost", 3, 3),
        ("cost", 3, 3),
        ("preference", 3, 3),
        ("preference", 3, 3),
    ]
    faults = {row["faults"]: (row["completed"], row["rollouts"]) for row in found["faults"]}
    assert faults == dict.fromkeys(SPELLINGS, (2, 2)) | {"knock": (1, 2)}
    assert "- case_study_3, knock: 1 x the log refutes it" in page
    boundaries = {result["key"]: result["boundary"] for result in found["boundaries"]}
    assert boundaries == {name: [key.greatest, None] for name, key in KEYS.items()} | {"bias": [2.8125, 3.125]}
    words = "completion falls below 95% between 2.8125 and 3.125 mm | 3 x the log refutes it"
    assert f"| case_study_3 | bias, mm | {words}" in page
