"""Forged logs are refuted at the documented level, by the intended check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from forged_logs import log_of_run, refutations
from forgeries import PLAIN, RESIMULATED, SCENARIO, SIGNED, Forgery, detail
from scenario_texts import PLACES_NEARBY, cup_scenario

from prefplan.scenario.decode import Scenario, loads
from sim.evidence.certificate import certify
from sim.evidence.log import Log, encode, read_log
from sim.evidence.signature import check_signature, sign
from sim.execution.faults import move
from sim.execution.faults.fault import read_fault


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return loads(cup_scenario(places=PLACES_NEARBY), name="cup")


@pytest.fixture(scope="module")
def cup_log(scenario: Scenario) -> Log:
    return log_of_run(scenario, seed=3)


@pytest.fixture(scope="module")
def key() -> Ed25519PrivateKey:
    return Ed25519PrivateKey.generate()


def named(forgery: Forgery) -> str:
    return forgery.what


def test_the_honest_log_is_confirmed_at_every_level(cup_log: Log, scenario: Scenario) -> None:
    certificate = certify(cup_log, scenario=scenario, again=True)
    assert certificate.refuted == () and len(PLAIN + SCENARIO + RESIMULATED + SIGNED) >= 40
    assert certificate.check("simulated again").words.endswith("every digit equal")


@pytest.mark.parametrize("fault", ["knock:cup@1", "slip@3", "miss:1@2", "foreign:tray@1", "move:cup@1"])
def test_what_a_fault_does_is_physics(scenario: Scenario, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With this seed the cup is moved beyond the table: it falls for metres, which is no jump."""
    monkeypatch.setattr(move, "is_carried", lambda *place: True)
    late = "latency=30" if fault.startswith("slip") else ""  # the gripper opens later than it is told to
    faults = [read_fault(fault, scenario.model)]  # type: ignore[arg-type]
    log = log_of_run(scenario, seed=3, faults=faults, perturbation=late)
    certificate = certify(log, again=True)
    assert [check for check in certificate.motions if not check.holds] == []
    assert certificate.check("faults").words.startswith("1, as asked for") and certificate.check("events").holds
    fell = log.qpos[:, log.about.joints["cup"] + 2].min() < -1
    assert fell == fault.startswith("move")


def test_what_moves_is_placed_somewhere_between_two_frames(cup_log: Log) -> None:
    (placed,) = (event for event in cup_log.about.events if event.kind == "placed")
    x, after = cup_log.about.joints["cup"], int(np.searchsorted(cup_log.times, placed.time + 1e-9))
    told = detail("placed", error_mm=placed.detail["error_mm"] + 3)(cup_log)
    for moved, holds in ((slice(after, after + 1), True), (slice(after - 1, after + 1), False)):
        qpos = cup_log.qpos.copy()
        qpos[moved, x] += 0.006
        assert certify(replace(told, qpos=qpos)).check("events").holds == holds


@pytest.mark.parametrize("forgery", PLAIN, ids=named)
def test_the_log_alone_refutes(cup_log: Log, forgery: Forgery) -> None:
    assert forgery.check in refutations(forgery.forge(cup_log))


@pytest.mark.parametrize("forgery", SCENARIO, ids=named)
def test_the_scenario_refutes(cup_log: Log, scenario: Scenario, forgery: Forgery) -> None:
    forged = forgery.forge(cup_log)
    assert certify(forged).check("scenario hash").holds
    check = certify(forged, scenario=scenario).check("scenario")
    assert not check.holds and " in the log, " in check.words


@pytest.mark.parametrize("forgery", RESIMULATED, ids=named)
def test_a_simulation_refutes(cup_log: Log, forgery: Forgery) -> None:
    check = certify(forgery.forge(cup_log), again=True).check(forgery.check)
    assert not check.holds and " s" in check.words


@pytest.mark.parametrize("forgery", SIGNED, ids=named)
def test_only_the_signature_refutes(cup_log: Log, forgery: Forgery, key: Ed25519PrivateKey, tmp_path: Path) -> None:
    assert certify(forgery.forge(cup_log)).confirmed
    (tmp_path / "honest.npz").write_bytes(sign(encode(cup_log), key))
    signature = (tmp_path / "honest.npz").read_bytes()[-64:]
    forged = encode(forgery.forge(read_log(tmp_path / "honest.npz")))
    for contents in (forged, forged[:-2] + b"\x40\x00" + signature, sign(forged, Ed25519PrivateKey.generate())):
        assert not check_signature(contents, key.public_key()).holds


def test_every_changed_byte_of_a_signed_log_is_refuted(cup_log: Log, key: Ed25519PrivateKey, tmp_path: Path) -> None:
    contents, path = sign(encode(cup_log), key), tmp_path / "signed.npz"
    path.write_bytes(contents)
    assert read_log(path).about == cup_log.about and check_signature(contents, key.public_key()).holds
    for place in range(0, len(contents), 997):
        changed = contents[:place] + bytes([contents[place] ^ 1]) + contents[place + 1 :]
        assert not check_signature(changed, key.public_key()).holds
    assert not check_signature(contents + b" ", key.public_key()).holds
    assert not check_signature(b"", key.public_key()).holds
