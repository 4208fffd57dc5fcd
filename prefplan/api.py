"""The public names of `prefplan`."""

from prefplan.errors import FormulaError, ModelError, PreferenceError, PrefplanError, ScenarioError
from prefplan.front import Front, NoPlanError, Reason, Stats, UnfinishedError
from prefplan.heuristics.prepare import Options
from prefplan.ledger import Entry, Ledger
from prefplan.logic.dfa import Automaton, automaton
from prefplan.logic.formula import Formula
from prefplan.logic.normal_form import parse
from prefplan.logic.tasks import Relaxation, Rule, Task
from prefplan.models.graph import GraphModel, Transition
from prefplan.models.grid import GridModel, Terrain
from prefplan.models.manipulation.model import Location, ManipulationModel, ManipulationState, Object
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator
from prefplan.models.manipulation.surroundings import Fixture, RobotSetup
from prefplan.models.manipulation.symbolic import Action
from prefplan.models.transition_system import TransitionSystem
from prefplan.plan import Plan, Purchase
from prefplan.planner import Planner, best_plan, cheapest_plan, pareto_front, preferred_plan
from prefplan.preferences.kinds import Deadline, Due, Expression, Function, Max, Order, Preference, Sum, WeightedSum
from prefplan.preferences.objective import NamedPreference
from prefplan.problem import Problem
from prefplan.scenario.decode import Scenario, load
from prefplan.search.bounds import FrontLimits, PlanLimits
