"""`prefplan robots`: the robots to choose from."""

from __future__ import annotations

import pytest
from command_line import Run

from sim.robots.catalogue import ROBOTS


@pytest.fixture(autouse=True)
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let git reach no repository."""
    monkeypatch.setenv("GIT_ALLOW_PROTOCOL", "none")


def test_every_robot_is_listed_with_whether_it_can_be_had(run: Run) -> None:
    result = run("robots", "--json")
    assert (result.status, result.err) == (0, "")
    found = {one["name"]: one for one in result.json["robots"]}
    assert list(found) == list(ROBOTS)
    panda = {"title": ROBOTS["panda"].title, "degrees_of_freedom": 7, "payload_kg": 3, "available": True}
    assert found["panda"] == {"name": "panda", **panda, "reason": None}
    assert found["menagerie"]["available"] == (found["menagerie"]["reason"] is None)


def test_a_robot_that_cannot_be_had_is_told_why(
    run: Run, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path_factory.mktemp("empty")))
    result = run("robots")
    assert result.status == 0
    assert "it is not cached and cannot be fetched: transport 'https' not allowed" in " ".join(result.out.split())
