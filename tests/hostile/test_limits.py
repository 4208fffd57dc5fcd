"""Limits hold from the first byte: while files are read, unpacked and built."""

from __future__ import annotations

import gzip
import json
import os
import resource
import subprocess
import sys
import time
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import pytest
from hostile_bench import BENCH, write_bench
from scenario_texts import shipped

from prefplan import load, parse
from prefplan.errors import LimitError, ModelError, ScenarioError
from prefplan.limits import CLOCK_PERIOD, Limits
from prefplan.models.manipulation.measured_costs import read_measurements
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import loads
from prefplan.scenario.files import path_of
from sim.errors import SimulationError
from sim.geometry import mjcf_limits
from sim.world.scene import build_scene

PROGRAM = [sys.executable, "-c", "import sys; from experiments.commands.command_line import main; sys.exit(main())"]

GRID = """
[model]
kind = "grid"
size = [5000, 5000]
start = [0, 0]
cost = 1
[model.regions]
goal = [4999, 4999, 4999, 4999]
[[tasks]]
name = "go"
formula = "F goal"
[preference]
kind = "order"
"""

ROADS = """
[model]
kind = "graph"
file = "roads.csv.gz"
start = "s0"
[model.labels]
s1 = ["plant"]
[[tasks]]
name = "go"
formula = "F plant"
[preference]
kind = "order"
"""


def call(*arguments: str, memory: int | None = None) -> tuple[int, str, float, float]:
    """Return the exit status of a command, its stderr, its time, s, and its memory, MiB."""
    began = time.perf_counter()
    allowed = (lambda: resource.setrlimit(resource.RLIMIT_AS, (memory, memory))) if memory else None
    code = (
        "import resource, subprocess, sys; done = subprocess.run(sys.argv[1:], capture_output=True, text=True);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss); print(done.stderr, file=sys.stderr, end='');"
        "sys.exit(done.returncode)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *PROGRAM, "-q", *arguments], capture_output=True, text=True, preexec_fn=allowed
    )
    return done.returncode, done.stderr, time.perf_counter() - began, int(done.stdout) / 1024


@pytest.fixture(scope="module")
def idle() -> float:
    """Memory of a command that reads a small scenario, MiB."""
    return call("front", "example")[3]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["front", "plan", "check"])
def test_a_huge_grid_stays_within_its_memory(command: str, tmp_path: Path, idle: float) -> None:
    (tmp_path / "huge.toml").write_text(GRID)
    status, told, _, used = call(command, str(tmp_path / "huge.toml"), "--max-memory", "300")
    assert used < 1.1 * (idle + 300) and "Traceback" not in told
    assert status in (0, 4)


def test_a_file_that_unpacks_to_gigabytes_stays_within_its_memory(tmp_path: Path, idle: float) -> None:
    with gzip.open(tmp_path / "roads.csv.gz", "wb", compresslevel=1) as file:
        for _ in range(600):
            file.write(b"a" * 2**20)
    (tmp_path / "roads.toml").write_text(ROADS)
    status, told, _, used = call("front", str(tmp_path / "roads.toml"), "--max-memory", "100")
    assert (tmp_path / "roads.csv.gz").stat().st_size < 6e6
    assert status == 4 and used < 1.1 * (idle + 100) and "memory" in told and "Traceback" not in told


def test_a_scenario_without_end_is_refused_and_a_long_one_stays_within_its_time() -> None:
    status, told, _, used = call("front", "/dev/zero")
    assert status == 2 and "/dev/zero: has more than 4000000 letters" in told and used < 500
    edges = ", ".join(f'{{from = "s{i}", to = "s{i + 1}"}}' for i in range(CLOCK_PERIOD))
    text = ROADS.replace('file = "roads.csv.gz"', f"transitions = [{edges}]")
    for read in (partial(loads, text), partial(parse, " | ".join(["a"] * CLOCK_PERIOD))):
        with Limits(seconds=0), pytest.raises(LimitError, match="stopped by the time limit"):
            read()


def test_a_file_of_a_million_nodes_and_links_stays_within_its_time(tmp_path: Path) -> None:
    count = 10**6
    links = ({"source": f"s{i}", "target": f"s{i + 1}", "cost": 1} for i in range(count))
    nodes = ({"id": f"s{i}"} for i in range(count + 1))
    (tmp_path / "roads.json").write_text(json.dumps({"nodes": [*nodes], "links": [*links]}))
    (tmp_path / "roads.toml").write_text(ROADS.replace("roads.csv.gz", "roads.json"))
    without = call("front", "example")[2]
    for seconds in (0.5, 2.5):  # while it is parsed, and while the graph is made
        status, told, taken, _ = call("front", str(tmp_path / "roads.toml"), "--max-seconds", str(seconds))
        assert status == 4 and taken < without + seconds + 1 and "time limit" in told


@pytest.mark.parametrize(
    ("element", "words"),
    [
        ('<worldbody><replicate count="100000000"><geom size="1"/></replicate></worldbody>', "build it within 2 s"),
        (
            '<worldbody><composite type="cable" curve="s" count="100000000 1 1" size="1">'
            '<geom type="capsule" size="1"/></composite></worldbody>',
            "build it within 2 s",
        ),
        ('<size nkey="1000000000"/>', "build it within 2 s"),
        ('<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>', "build it within .* 2000 MB"),
        ('<asset><mesh name="m" builtin="plate" params="100000 100000"/></asset>', "build it within .* 2000 MB"),
        ('<asset><model name="m" file="bench.xml"/></asset>', "build it within"),  # endless, until MuJoCo crashes
        ("<worldbody>" + "<body>" * 5000 + "</body>" * 5000 + "</worldbody>", "nesting is too deep"),
    ],
)
def test_a_scene_that_exhausts_or_crashes_mujoco_is_refused(
    element: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mjcf_limits, "MAX_SECONDS", 2)
    model = write_bench(tmp_path, scene=BENCH.replace('<include file="light.xml"/>', element)).model
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match=f"scene: .*bench.xml: .*{words}"):
        build_scene(model)


def test_building_a_scene_stays_within_the_time_of_a_command(tmp_path: Path) -> None:
    scene = BENCH.replace("<worldbody>", '<worldbody><replicate count="100000000"><geom size="1"/></replicate>')
    write_bench(tmp_path, scene=scene)
    status, told, taken, _ = call("check", str(tmp_path / "bench.toml"), "--max-seconds", "3")
    assert status == 0 and "stopped by the time limit" in told and taken < 10


def test_files_that_include_one_another_twice_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mjcf_limits, "MAX_SECONDS", 2)
    model = write_bench(tmp_path).model
    for k in range(30):
        twice = f'<include file="{k + 1}.xml"/>' * 2
        (tmp_path / f"{k}.xml").write_text(f"<mujoco>{twice}</mujoco>")
    (tmp_path / "30.xml").write_text("<mujoco><worldbody/></mujoco>")
    (tmp_path / "bench.xml").write_text(BENCH.replace("light.xml", "0.xml"))
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match="build it within 2 s"):
        build_scene(model)


def test_files_of_a_scene_that_are_too_large_to_be_read_are_refused(tmp_path: Path) -> None:
    (tmp_path / "endless.xml").symlink_to("/dev/zero")
    for name, words in (("endless.xml", "no regular file"), ("long.xml", "larger than 20000000 bytes")):
        model = write_bench(tmp_path, scene=BENCH.replace("light.xml", name)).model
        os.truncate(tmp_path / "light.xml", 30_000_000)
        (tmp_path / "light.xml").rename(tmp_path / "long.xml")
        assert isinstance(model, ManipulationModel)
        with pytest.raises(SimulationError, match=f"scene: .*{name}: {words}"):
            build_scene(model)


def test_a_mesh_that_is_too_large_to_be_read_is_refused(tmp_path: Path) -> None:
    mesh = '<asset><mesh file="endless.stl"/></asset>'
    model = write_bench(tmp_path, scene=BENCH.replace("<worldbody>", f"{mesh}<worldbody>")).model
    (tmp_path / "endless.stl").symlink_to("/dev/zero")
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match="scene: .*endless.stl: no regular file"):
        build_scene(model)


@pytest.mark.parametrize("name", ["roads.csv", "roads.csv.gz"])
def test_a_graph_that_is_no_regular_file_is_refused(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / name)  # opening it would wait for a writer
    (tmp_path / "roads.toml").write_text(ROADS.replace("roads.csv.gz", name))
    with pytest.raises(ScenarioError, match=rf"model.file: {name}: cannot be read: no regular file"):
        load(tmp_path / "roads.toml").problem()


def test_a_file_of_measurements_that_is_too_large_to_be_read_is_refused(tmp_path: Path) -> None:
    scenario = shipped("kitchen_energy")
    assert isinstance(scenario.model, ManipulationModel)
    measured = path_of("kitchen_energy").with_suffix(".measured.json").read_text()
    for longer, accepted in ((0, True), (10_000_000, True), (20_000_000, False)):  # 130 poses of the hand take 4.8 MB
        (tmp_path / "long.json").write_text(measured + " " * longer)
        with nullcontext() if accepted else pytest.raises(ModelError, match="cannot be read or is damaged"):
            read_measurements(tmp_path / "long.json", scenario.model)


@pytest.mark.parametrize("element", ['<include file="{0}/light.xml"/>', '<compiler meshdir="{0}"/>'])
def test_a_scene_that_names_files_by_absolute_paths_is_refused_before_it_is_built(element: str, tmp_path: Path) -> None:
    """A log holds the files of its scene, and nobody could check one that lie elsewhere."""
    scene = BENCH.replace('<include file="light.xml"/>', element.format(tmp_path))
    model = write_bench(tmp_path, scene=scene).model
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match="scene: .*bench.xml: '/.*' is no path relative to the file"):
        build_scene(model)


def test_little_virtual_memory_ends_with_a_sentence() -> None:
    status, told, _, _ = call("front", "kitchen", memory=500_000 * 1024)
    assert status == 4 and told.startswith("prefplan: ulimit -v: 488 MiB of virtual memory are allowed, 1536 needed\n")
    assert all(line.startswith("prefplan: ") for line in told.splitlines())
