"""Options that several commands have, as decorators."""

from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import Any, TypedDict

import click

from experiments import scenarios
from experiments.cli import values
from experiments.cli.choice import Wanted

Function = Callable[..., Any]
Decorator = Callable[[Function], Function]


class FaultOption(click.Option):
    """An option whose help ends with the kinds of faults; they are loaded when it is shown."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option and its help."""
        with suppress(ModuleNotFoundError):  # without the simulation there are no faults
            from sim.execution.faults.fault import kinds

            self.help = f"{str(self.help).partition(':')[0]}: {', '.join(kind.form() for kind in kinds().values())}."
        return super().get_help_record(ctx)


def gathered(name: str, make: Callable[..., Any], **options: Decorator) -> Decorator:
    """Return a decorator that adds options, in this order; a command gets `make(**options)` as the argument `name`."""

    def decorate(function: Function) -> Function:
        @wraps(function)
        def called(**given: Any) -> Any:
            return function(**{name: make(**{key: given.pop(key) for key in options})}, **given)

        added: Function = called
        for option in reversed(options.values()):
            added = option(added)
        return added

    return decorate


def objective_names(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Return the names of objectives that every scenario accepts and that begin with a text."""
    return [name for name in ("cost", "preference") if name.startswith(incomplete)]


scenario = click.argument(
    "scenario",
    shell_complete=values.files(".toml", scenarios.names),
    help="Name of a scenario that `prefplan list` shows, or path of a TOML file.",
)
as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
plot = click.option(
    "--plot", metavar="FILE", type=click.Path(), help="Draw a figure too; the file ends in .png, .svg or .pdf."
)
abstract = click.option(
    "--abstract",
    is_flag=True,
    help="Plan without asking the simulated arm what it can do (default: ask, if the simulation is installed and the "
    "scenario does not say `abstract = true`).",
)
max_cost = click.option(
    "--max-cost",
    type=values.number,
    metavar="C",
    help="Greatest total cost of a plan; required if the preference's contract is general.",
)
max_preference = click.option("--max-preference", type=values.number, metavar="M", help="Greatest penalty of a plan.")
at_most = click.option(
    "--at-most",
    type=values.named_number,
    multiple=True,
    callback=lambda context, parameter, pairs: dict(pairs),
    metavar="NAME=VALUE",
    help="Upper bound on a cost or a preference by its name, such as energy=40; may be repeated.",
)
which = gathered(
    "wanted",
    Wanted,
    plan=click.option(
        "--plan",
        type=values.which_plan,
        default="cost",
        metavar="cost|preference|INDEX",
        help="Which plan of the front: the cheapest, the preferred (these words do as well), or by its number from 0 "
        "(default: cost).",
    ),
    max_preference=max_preference,
    max_cost=max_cost,
)
"""The choice of a plan of the front, which a command gets as `wanted`."""

fault = click.option(
    "--fault",
    "faults",
    multiple=True,
    cls=FaultOption,
    metavar="FAULT",
    help="Inject a fault at action K, or at the next one where it is possible; may be repeated",
)
perturb = click.option(
    "--perturb",
    metavar="KEY=VALUE,...",
    help="Greatest random differences: position, centre (of mass), noise and bias (of the camera) in mm; angle in "
    "degrees; latency in ms; friction, pads, table, force and mass as a share of 1 (default: position=5,angle=5).",
)

robot = click.option(
    "--robot",
    metavar="NAME",
    help="One of those that `prefplan robots` lists (default: the scenario's, or panda).",
)
no_video = click.option("--no-video", is_flag=True, help="Render no video.")
camera = click.option(
    "--camera",
    metavar="NAME",
    default="fixed",
    help="fixed: in front of the table; orbit: around its front; wrist: on the hand; top: from above; another camera "
    "of the scene's MJCF by its name; or azimuth and elevation in degrees and distance in m, such as 156,-28,1.2 "
    "(default: fixed).",
)


class LookOptions(TypedDict):
    """Values of the options `look`, read by `experiments.cli.simulation_options.look_of`."""

    quality: str
    camera: str
    size: tuple[int, int] | None


look = gathered(
    "look",
    LookOptions,
    quality=click.option(
        "--quality",
        metavar="NAME",
        default="draft",
        help="draft: 1280 x 720; final: 1920 x 1080 with soft shadows, in ten times the time (default: draft).",
    ),
    camera=camera,
    size=click.option(
        "--size", type=values.picture_size, metavar="WxH", help="Width and height in pixels (default: the quality's)."
    ),
)
"""How videos are rendered, which a command gets as `look`."""

no_open = click.option("--no-open", is_flag=True, help="Print the address of the page, but open no browser.")
jobs = click.option("--jobs", type=values.POSITIVE, metavar="N", help="Number of processes (default: one per core).")


def seed(starts: str = "at random by up to 5 mm and 5 degrees") -> Decorator:
    """Return `--seed`, whose help says where objects start."""
    told = f"Start each object off its nominal pose, {starts} (default: nominal poses)."
    return click.option("--seed", type=values.WHOLE, metavar="N", help=told)


def out(default: str = "out/SCENARIO") -> Decorator:
    """Return `--out`, whose help says where results go without it."""
    return click.option("--out", type=values.PATH, metavar="DIR", help=f"Folder for the results (default: {default}).")


def limits(found: str = "what is known by then") -> Decorator:
    """Return the limits of a search, whose help says what it has found when one is reached.

    A command gets them as `limits`, a context, from the time of its call.
    """
    time, memory = f"Stop after this time with {found}.", f"Stop before the search uses more memory, with {found}."
    return gathered(
        "limits",
        _limits,
        max_seconds=click.option("--max-seconds", type=values.seconds, metavar="S", help=time),
        max_memory=click.option("--max-memory", type=values.megabytes, metavar="MiB", help=memory),
    )


def _limits(*, max_seconds: float | None, max_memory: float | None) -> Any:
    from prefplan.limits import Limits  # loads numpy, which the help can do without

    return Limits.of(max_seconds, max_memory)
