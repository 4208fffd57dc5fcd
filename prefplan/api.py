"""What `import prefplan` offers."""

from prefplan.errors import FormulaError, ModelError, PreferenceError, PrefplanError, ScenarioError
from prefplan.front import Front, NoPlanError, Plan, Purchase, Reason, Stats, UnfinishedError
from prefplan.heuristics.preprocessing import Options
from prefplan.ledger import Entry, Ledger
from prefplan.logic.dfa import Automaton, automaton
from prefplan.logic.formula import Formula, parse
from prefplan.models.grid import GridModel
from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.model import Location, ManipulationModel, ManipulationState, Object
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator
from prefplan.models.transition_system import TransitionSystem
from prefplan.planner import FrontLimits, PlanLimits, Planner, cheapest_plan, pareto_front, preferred_plan
from prefplan.preferences.kinds import Deadline, Due, Expression, Function, Max, Order, Preference, Sum, WeightedSum
from prefplan.problem import Problem, Relaxation, Task
from prefplan.scenario.decode import Scenario, load

__all__ = [
    "Action",
    "Automaton",
    "Deadline",
    "Due",
    "Entry",
    "Expression",
    "Formula",
    "FormulaError",
    "Front",
    "FrontLimits",
    "Function",
    "GridModel",
    "Ledger",
    "Location",
    "ManipulationModel",
    "ManipulationState",
    "Max",
    "ModelError",
    "NoPlanError",
    "Object",
    "Operator",
    "Options",
    "Order",
    "Plan",
    "PlanLimits",
    "Planner",
    "Preference",
    "PreferenceError",
    "PrefplanError",
    "Problem",
    "Purchase",
    "Reason",
    "Relaxation",
    "STANDARD_OPERATORS",
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
