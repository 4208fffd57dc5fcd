"""`prefplan export`: what it writes, and what it refuses."""

from __future__ import annotations

import shutil
from pathlib import Path

import mujoco
import pytest
from command_line import Run, assert_is_error
from scenario_texts import CUP

from sim.export import gltf, mjcf


def test_the_file_lies_beside_the_log_unless_another_place_is_named(
    run: Run, run_log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A page of the guide shows a real file being written."""
    monkeypatch.setattr(gltf, "encode_glb", lambda logs: logs["cost"].about.scenario.encode())
    cup = Path(shutil.copy(run_log, "."))
    result = run("export", str(cup), "--to", "glb")
    assert (result.status, result.out, result.err) == (0, f"{cup.with_suffix('.glb')}\n", "")
    assert cup.with_suffix(".glb").read_text() == "cup"
    assert_is_error(run("export", str(cup), "--to", "glb"), "cost.glb: already exists; --force replaces it")
    assert run("export", str(cup), "--to", "glb", "--force").status == 0
    assert run("export", str(cup), "--to", "glb", "--out", "new/arm.GLB").out == "new/arm.GLB\n"
    assert [path.name for path in Path("new").iterdir()] == ["arm.GLB"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["no.npz", "--to", "glb"], "no.npz: no such file"),
        (["case_study_3", "--to", "glb"], "case_study_3: --to glb takes the log of a run"),
        (["text.npz", "--to", "glb"], "text.npz: broken, or not a log"),
        (["text.npz", "--to", "glb", "--out", "arm.gltf"], "arm.gltf: the file's name ends in .glb"),
        (["text.npz", "--to", "gbl"], "Invalid value for '--to': 'gbl' is not one of 'glb', 'mjcf'."),
        (["text.npz", "--to", "mjcf"], "text.npz: --to mjcf takes a scenario's name or file, not the log of a run"),
        (
            ["text.npz", "--to", "glb", "--robot", "fetch"],
            "--robot: only with --to mjcf; the log of a run names its robot",
        ),
        (
            ["case_study_3", "--to", "mjcf", "--robot", "sofa"],
            "prefplan: unknown robot 'sofa' (valid: fetch, gen3, panda, ",
        ),
        (["text.npz"], "Missing option '--to'. Choose from: glb, mjcf"),
    ],
)
def test_what_cannot_be_exported_is_said(run: Run, tmp_path: Path, words: list[str], message: str) -> None:
    Path("text.npz").write_text("no log")
    assert_is_error(run("export", *words), message)
    assert [path.name for path in tmp_path.iterdir()] == ["text.npz"]


def test_a_scene_needs_no_measured_costs_and_may_have_several(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mjcf, "encode_mjcf", lambda scene: {"scene.xml": b"<mujoco/>"})
    start = CUP.index("costs = ")
    text = f"{CUP[:start]}costs = {{ measured = ['time', 'energy'] }}{CUP[CUP.index(chr(10), start) :]}"
    Path("cup.toml").write_text(text)
    assert run("export", "cup.toml", "--to", "mjcf").status == 0


def test_a_scene_is_written_as_a_folder_that_mujoco_reads(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("cup.toml").write_text(CUP)
    result = run("export", "cup.toml", "--to", "mjcf")
    assert (result.status, result.out) == (0, "out/cup/mjcf/scene.xml\n")
    model = mujoco.MjModel.from_xml_path("out/cup/mjcf/scene.xml")
    assert model.key("start").qpos.shape == (model.nq,)
    assert_is_error(run("export", "cup.toml", "--to", "mjcf"), "out/cup/mjcf: already exists; --force replaces it")
    monkeypatch.setattr(mjcf, "encode_mjcf", lambda scene: {"scene.xml": scene.robot.name.encode()})
    assert run("export", "cup.toml", "--to", "mjcf", "--force", "--robot", "panda_suction").status == 0
    assert Path("out/cup/mjcf/scene.xml").read_text() == "panda_suction"
    assert_is_error(run("export", "none", "--to", "mjcf"), "none")
