"""Optimal cost-preference trade-off planning with multiple temporal tasks.

After P. Amorese and M. Lahijanian, "Optimal Cost-Preference Trade-off Planning with Multiple Temporal Tasks",
IROS 2023.
"""

from prefplan.automaton import Automaton, automaton
from prefplan.errors import FormulaError, ModelError, PreferenceError, PrefplanError, ScenarioError
from prefplan.formula import Formula, parse
from prefplan.front import Front, NoPlanError, Plan, Reason, Stats
from prefplan.models.grid import GridModel
from prefplan.models.manipulation import Location, ManipulationModel, ManipulationState, Object
from prefplan.planner import Planner, cheapest_plan, pareto_front, preferred_plan
from prefplan.preference import Deadline, Due, Order, WeightedSum
from prefplan.problem import Problem, Task
from prefplan.scenario import Scenario, load
from prefplan.transition_system import TransitionSystem

__all__ = [
    "Automaton",
    "Deadline",
    "Due",
    "Formula",
    "FormulaError",
    "Front",
    "GridModel",
    "Location",
    "ManipulationModel",
    "ManipulationState",
    "ModelError",
    "NoPlanError",
    "Object",
    "Order",
    "Plan",
    "Planner",
    "PreferenceError",
    "PrefplanError",
    "Problem",
    "Reason",
    "Scenario",
    "ScenarioError",
    "Stats",
    "Task",
    "TransitionSystem",
    "WeightedSum",
    "automaton",
    "cheapest_plan",
    "load",
    "parse",
    "pareto_front",
    "preferred_plan",
]
