"""Optimal cost-preference trade-off planning with multiple temporal tasks.

After P. Amorese and M. Lahijanian, "Optimal Cost-Preference Trade-off Planning with Multiple Temporal Tasks",
IROS 2023.
"""

from prefplan.automaton import Automaton, automaton
from prefplan.errors import FormulaError, ModelError, PreferenceError, PrefplanError, ScenarioError
from prefplan.formula import Formula, parse
from prefplan.front import Front, NoPlanError, Plan, Purchase, Reason, Stats, UnfinishedError
from prefplan.models.grid import GridModel
from prefplan.models.manipulation import Location, ManipulationModel, ManipulationState, Object
from prefplan.planner import Planner, cheapest_plan, pareto_front, preferred_plan
from prefplan.preference import Deadline, Due, Expression, Function, Max, Order, Preference, Sum, WeightedSum
from prefplan.prepared import Options
from prefplan.problem import Problem, Relaxation, Task
from prefplan.scenario import Scenario, load
from prefplan.transition_system import TransitionSystem

__all__ = [
    "Automaton",
    "Deadline",
    "Due",
    "Expression",
    "Formula",
    "FormulaError",
    "Front",
    "Function",
    "GridModel",
    "Location",
    "ManipulationModel",
    "ManipulationState",
    "Max",
    "ModelError",
    "NoPlanError",
    "Object",
    "Options",
    "Order",
    "Plan",
    "Planner",
    "Preference",
    "PreferenceError",
    "PrefplanError",
    "Problem",
    "Purchase",
    "Reason",
    "Relaxation",
    "Scenario",
    "ScenarioError",
    "Stats",
    "Sum",
    "Task",
    "TransitionSystem",
    "UnfinishedError",
    "WeightedSum",
    "automaton",
    "cheapest_plan",
    "load",
    "pareto_front",
    "parse",
    "preferred_plan",
]
