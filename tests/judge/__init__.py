"""Judges: slow, simple implementations to check the planner against, which share none of its code or algorithms."""

from judge.enumerate import cheapest_cost, exact_front
from judge.manipulation import Arm, Cell
from judge.preferences import EXPRESSIONS, exact, random_preference, reference
from judge.problems import Edge, GraphProblem, JudgedTask, Relaxation, grid_problem
from judge.random_problems import random_errands, random_problem
from judge.replay import Replay, replay
from judge.semantics import holds, satisfaction_index
from judge.syntax import Formula, bracketed, parse, random_formula, random_text, to_text
