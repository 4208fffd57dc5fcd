"""Compile the kernels ahead of their first use: `python -m prefplan.warm_up`."""

from pathlib import Path

from prefplan.heuristics.prepare import Options, Prepared
from prefplan.logic.tasks import Task
from prefplan.models.kernels import SEARCH_CODE, compile_kernels
from prefplan.models.manipulation.description import Location, Object
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.transition_system import TransitionSystem
from prefplan.planner import Planner, pareto_front
from prefplan.preferences.kinds import Expression, Order
from prefplan.problem import Problem
from prefplan.product.product_automaton import Product
from prefplan.search import label_search
from prefplan.search.driver import LabelSearch
from prefplan.search.labels import rehash


def is_compiled() -> bool:
    """Return whether the machine code of the search is cached on disk, or not needed."""
    folder = code_folder()
    return folder is None or any(folder.glob(SEARCH_CODE))


def code_folder() -> Path | None:
    """Return the folder of the machine code of the search; None if there is none, with `NUMBA_DISABLE_JIT=1`."""
    compile_kernels()
    stats = getattr(label_search.run, "stats", None)
    return None if stats is None else Path(stats.cache_path)


def warm_up() -> None:
    """Solve small problems that together use every kernel."""
    compile_kernels()
    system = TransitionSystem.from_transitions(
        [("s", "go", "t", 1), ("t", "go", "s", 1)], start="s", labels={"s": ["a"], "t": ["b"]}
    )
    tasks = [Task("x", "F b"), Task("y", "F (b & F a)")]
    for preference in (Order(), Expression("x + min(x, y)"), Expression("abs(x - y) * x")):
        planner = Planner(Problem(system, tasks, preference))
        planner.front(max_cost=9)
        planner.cheapest()
    problem = Problem(system, tasks, Order())
    Planner(problem, options=Options(contraction=False)).front()
    Planner(problem, options=Options(heuristic=1)).cheapest()  # with landmarks
    pareto_front(Problem(_arm(), [Task("x", "F b_there")], Order()))
    prepared = Prepared(Product(problem), Options())
    search = LabelSearch(prepared, bounds={})
    rehash(search.memory.states, 0)
    prepared.improve(1)


def _arm() -> ManipulationModel:
    """Return a model whose states are generated."""
    locations = tuple(Location(name, (0.5, 0.2 * x)) for x, name in enumerate(("here", "there", "aside")))
    costs = dict.fromkeys(("transit", "grasp", "transport", "release"), 1)
    return ManipulationModel(
        start="here", locations=locations, objects=(Object("b", "here"),), costs=costs, listed_states=0
    )


if __name__ == "__main__":
    warm_up()
