"""Forged logs are refuted at the documented level, by the intended check."""

from __future__ import annotations

import pytest
from forged_logs import log_of_run, telling
from forgeries import PLAIN, RESIMULATED, SCENARIO, Forgery
from scenario_texts import PLACES_NEARBY, cup_scenario

from prefplan.scenario.decode import Scenario, loads
from sim.evidence.certificate import certify
from sim.evidence.log import Log
from sim.execution.faults import move
from sim.execution.faults.fault import read_fault


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return loads(cup_scenario(places=PLACES_NEARBY), name="cup")


@pytest.fixture(scope="module")
def cup_log(scenario: Scenario) -> Log:
    return log_of_run(scenario, seed=3)


def named(forgery: Forgery) -> str:
    return forgery.what


def elsewhere(log: Log) -> Log:
    """Return a log that names another version of MuJoCo."""
    return telling(log, versions=log.about.versions | {"mujoco": "3.0.0"})


def test_the_honest_log_is_proved_in_its_scenario_and_else_consistent(cup_log: Log, scenario: Scenario) -> None:
    certificate = certify(cup_log, scenario=scenario)
    assert certificate.refuted == () and certificate.verdict == "proved"
    assert len(PLAIN + SCENARIO + RESIMULATED) >= 56
    assert certificate.check("simulated again").words.endswith("every digit equal")
    assert certificate.check("scenario").words == "the given one, with the robot panda, seed 3"
    assert certify(cup_log).verdict == "consistent"
    certificate = certify(elsewhere(cup_log), scenario=scenario)
    assert certificate.verdict == "consistent"
    words = certificate.check("simulated again").words
    assert "each within 1 mm" in words and "within 5 mm in all (mujoco 3.0.0 then" in words and "not excluded" in words


@pytest.mark.parametrize("fault", ["knock:cup@1", "slip@3", "miss:1@2", "foreign:tray@1", "move:cup@1"])
def test_what_a_fault_does_is_physics(scenario: Scenario, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With this seed the cup is moved beyond the table: it falls for metres, which is no jump."""
    monkeypatch.setattr(move, "is_carried", lambda *place: True)
    # The gripper opens later than it is told to, by more than a frame.
    late = "position=5,angle=5,latency=200" if fault.startswith("slip") else ""
    faults = [read_fault(fault, scenario.model)]  # type: ignore[arg-type]
    log = log_of_run(scenario, seed=3, faults=faults, perturbation=late)
    certificate = certify(log)
    assert [check for check in certificate.motions if not check.holds] == []
    assert [check for check in certify(elsewhere(log)).motions if not check.holds] == []
    assert certificate.check("faults").words.startswith("1, as asked for") and certificate.check("events").holds
    fell = log.qpos[:, log.about.joints["cup"] + 2].min() < -1
    assert fell == fault.startswith("move")


def test_late_commands_are_no_jerks(scenario: Scenario) -> None:
    """With this latency (up to 150 ms), the last commands of a movement are still under way when the log ends."""
    log = log_of_run(scenario, seed=3, perturbation="position=5,angle=5,latency=150")
    assert certify(log, scenario=scenario).verdict == "proved" and certify(elsewhere(log)).verdict == "consistent"


@pytest.mark.parametrize("forgery", PLAIN, ids=named)
def test_default_options_refute(cup_log: Log, scenario: Scenario, forgery: Forgery) -> None:
    forged = forgery.forge(cup_log)
    assert forgery.check in {check.name for check in certify(forged).refuted}
    assert certify(elsewhere(forged)).verdict == "refuted"


@pytest.mark.parametrize("forgery", SCENARIO, ids=named)
def test_the_scenario_refutes(cup_log: Log, scenario: Scenario, forgery: Forgery) -> None:
    forged = forgery.forge(cup_log)
    assert certify(forged).verdict != "proved"
    check = certify(forged, scenario=scenario).check("scenario")
    assert not check.holds and " in the log, " in check.words


@pytest.mark.parametrize("forgery", RESIMULATED, ids=named)
def test_an_equal_environment_refutes(cup_log: Log, scenario: Scenario, forgery: Forgery) -> None:
    forged = forgery.forge(cup_log)
    check = certify(forged, scenario=scenario).check(forgery.check)
    assert not check.holds and " s" in check.words
    assert certify(elsewhere(forged), scenario=scenario).verdict != "proved"
