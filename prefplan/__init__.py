"""Plan several temporal tasks at every best trade-off of total cost and preference.

    import prefplan as pp

    places = {"kitchen": [(8, 0, 8, 0)], "ann": [(8, 5, 8, 5)], "post": [(0, 5, 0, 5)], "bob": [(4, 5, 4, 5)]}
    office = pp.GridModel(size=(9, 6), start=(0, 0), regions=places)
    tasks = {"coffee": "F (kitchen & F ann)", "letters": "F (post & F bob)"}
    problem = pp.Problem(office, tasks, pp.Order(["coffee", "letters"]))
    front = pp.pareto_front(problem)
    print(front)
    print(pp.cheapest_plan(problem, max_preference=0))
    print(pp.pareto_front("case_study_3"))

The names that matter:

    pareto_front        every best trade-off, as a Front of Plans
    cheapest_plan       one plan, of least cost within a bound on the penalty
    preferred_plan      one plan, of least penalty
    load                a Scenario: one that ships, by its name, or a TOML file, by its path
    Problem             a model or a networkx graph, with tasks and a preference
    GridModel           a model; also GraphModel and ManipulationModel
    Task                a co-safe formula that may be relaxed; also Rule, a formula that is never broken
    Order               a preference; also WeightedSum, Max, Deadline, Sum, and Expression or Function of one's own
    Front               the plans of a problem: print it, index it, `plot`, `to_pandas`
    Plan                its cost, preference, task_costs and actions
    automaton           the automaton of a formula
    PrefplanError       the base of all errors: what is wrong, where, and what would be right

After P. Amorese and M. Lahijanian, "Optimal Cost-Preference Trade-off Planning with Multiple Temporal Tasks",
IROS 2023.
"""

from typing import Any

import lazy_loader

# The public names are in `__init__.pyi`, and are loaded when the first of them is used: pytest imports this package
# wherever it is installed, for `prefplan.pytest_plugin`, and the tests of other projects should not wait for that.
_load, _, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Return a public name, loading all of them at the first use, or the version."""
    if name == "__version__":
        from importlib import metadata

        try:
            return metadata.version("prefplan")
        except metadata.PackageNotFoundError:
            return "unknown"
    if name in __all__:
        globals().update({each: _load(each) for each in __all__})
        return globals()[name]
    from difflib import get_close_matches

    near = get_close_matches(name, __all__, n=1)
    meant = f" (did you mean {near[0]!r}?)" if near else ""
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}{meant}")


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
