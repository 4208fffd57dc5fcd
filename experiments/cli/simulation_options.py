"""Values of options that need the simulation: `--perturb`, `--fault` and those of videos."""

from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches

from experiments.cli.options import LookOptions
from prefplan import ManipulationModel, PrefplanError, Scenario
from prefplan.errors import check_known, prefixed
from sim import Fault, Perturbation, Scene, read_fault
from sim.rendering.cameras import camera_names, read_view
from sim.rendering.quality import QUALITIES, Look
from sim.world.randomization import read_perturbation


def perturbation_of(text: str | None, *, seed: int | None) -> Perturbation:
    """Return the value of `--perturb`, by default 5 mm and 5 degrees; raise PrefplanError if it needs a seed."""
    if text is None:
        return Perturbation()
    if seed is None:
        raise PrefplanError("--perturb: needs --seed, from which the random differences are drawn: --seed 1")
    with prefixed("--perturb: "):
        return read_perturbation(text)


def faults_of(texts: Sequence[str], scenario: Scenario) -> tuple[Fault, ...]:
    """Return the values of `--fault`, or raise PrefplanError; none for a scenario without a manipulation model."""
    if not isinstance(scenario.model, ManipulationModel):
        return ()
    with prefixed("--fault "):
        return tuple(read_fault(text, scenario.model) for text in texts)


def look_of(scene: Scene, options: LookOptions) -> Look:
    """Return the values of `--quality`, `--size` and `--camera`, or raise PrefplanError."""
    check_known("--quality", "name", options["quality"], QUALITIES, PrefplanError)
    quality = QUALITIES[options["quality"]]
    size = options["size"] or quality.size
    return {"quality": replace(quality, size=size), "camera": camera_of(options["camera"], scene)}


def camera_of(name: str, scene: Scene) -> str:
    """Return the value of `--camera`, the name of a scene's camera or `az,el,dist`, or raise PrefplanError."""
    names = camera_names(scene)
    if name in names:
        return name
    if "," not in name:
        near = [f"did you mean {each!r}? " for each in get_close_matches(name, names, n=1)]
        valid = f"{''.join(near)}valid: {', '.join(names)}, or a view such as 156,-28,1.2"
        raise PrefplanError(f"--camera: unknown name {name!r} ({valid})")
    with prefixed("--camera: "):
        read_view(name)
    return name
