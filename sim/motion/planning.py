"""Motion planning in joint space: OMPL's RRT-Connect and path simplification, for any robot and collision check.

J. J. Kuffner and S. M. LaValle, "RRT-Connect: An efficient approach to single-query path planning", ICRA 2000.
"""

from collections.abc import Callable, Collection

import numpy as np
from ompl import base, geometric, util

from sim.errors import BlockedError, SimulationError

MAX_CHECKS = 20000
"""Greatest number of configurations that a search checks; a path round a wall needs a few hundred."""

MAX_SIMPLIFICATION_CHECKS = 3000
"""Greatest number of configurations that are checked to shorten a path."""

SEARCHES = 3
"""Number of searches, of which the shortest path is returned; if the first one fails, there are no others."""

EDGE_STEPS_M = (0.02, 0.01, 0.005)
"""Distances between checks on an edge, as bounds on how far a point of the robot moves. The first one is coarse: the
motion along the path is checked again, densely, and if that fails, the next distance is used."""

MAX_EDGE_M = 0.2
"""Longest edge of a search tree, as a bound on how far a point of the robot moves: with OMPL's default, a fifth of the
extent of the space, paths out of a shelf take 10 times as many checks."""

PATH_MARGIN_RAD = 0.02
"""Distance of planned paths from the joints' position limits, rad or m, unless they begin or end nearer to them."""

Touches = Callable[[np.ndarray], Collection[str]]
"""Returns the names of the bodies in collision at (n,) joint angles, rad or m."""


class MotionPlanner:
    """Plans collision-free paths of n joints. The same seed and query give the same path."""

    def __init__(self, ranges: np.ndarray, levers: np.ndarray, *, seed: int = 0, searches: int = SEARCHES) -> None:
        """Plan for joints with (n, 2) position limits, rad or m, and (n,) levers, m per rad or m.

        A lever is how far a joint can move a point of the robot, and its weight in the length of a path.
        """
        self._searches = searches
        self._low, self._high = ranges.T + np.array([[1.0], [-1.0]]) * PATH_MARGIN_RAD
        self._levers, self._seed = levers, seed
        # Each search sets the seed, and OMPL complains of it.
        util.setLogLevel(util.LOG_NONE)

    def plan(
        self, start: np.ndarray, goal: np.ndarray, touches: Touches, *, step: float = EDGE_STEPS_M[0]
    ) -> np.ndarray:
        """Return a path, (K, n) configurations from start to goal, straight between one and the next.

        Args:
            start: (n,) rad or m.
            goal: (n,) rad or m.
            touches: the collision check.
            step: distance between checks on an edge, m; see `EDGE_STEPS_M`.

        Raises:
            BlockedError: there is a collision at the start or the goal, or no path was found.
            SimulationError: the start is beyond the position limits.
        """
        if (np.maximum(self._low - start, start - self._high) > 2 * PATH_MARGIN_RAD).any():
            raise SimulationError("the arm is beyond the position limits of its joints")
        for q, where in ((start, "start"), (goal, "goal")):
            if met := touches(q):
                raise BlockedError(f"the arm would touch {' and '.join(sorted(met))} at its {where}", set(met))
        # If start or goal is out of bounds, OMPL waits for other ones forever.
        low, high = np.min([self._low, start, goal], axis=0), np.max([self._high, start, goal], axis=0)
        found: list[np.ndarray] = []
        for number in range(self._searches):
            search = _Search(low, high, self._levers, touches, step)
            path = search.path(start, goal, seed=SEARCHES * self._seed + number)
            if path is not None:
                found.append(path)
            elif not found:
                straight = np.linspace(start, goal, 2 + int(self._length(np.array([start, goal])) / step))
                between = {name for q in straight for name in touches(q)} or search.met
                words = f"no path past {' and '.join(sorted(between))} was found in {MAX_CHECKS} samples"
                raise BlockedError(words, between)
        return min(found, key=self._length)

    def _length(self, path: np.ndarray) -> float:
        return float(np.linalg.norm(self._levers * np.diff(path, axis=0), axis=1).sum())


class _Search:
    """One query in OMPL, in joint angles times their levers: distances are in metres; `met` are bodies in collision."""

    def __init__(self, low: np.ndarray, high: np.ndarray, levers: np.ndarray, touches: Touches, step: float) -> None:
        self._levers, self._touches, self._n = levers, touches, len(levers)
        self._checks, self.met = 0, set[str]()
        self._space = base.RealVectorStateSpace(self._n)
        bounds = base.RealVectorBounds(self._n)
        for joint, (least, greatest) in enumerate(zip(low * levers, high * levers, strict=True)):
            bounds.setLow(joint, float(least))
            bounds.setHigh(joint, float(greatest))
        self._space.setBounds(bounds)
        self._space.setLongestValidSegmentFraction(step / self._space.getMaximumExtent())
        self._info = base.SpaceInformation(self._space)
        self._info.setStateValidityChecker(self._is_free)
        self._info.setup()

    def path(self, start: np.ndarray, goal: np.ndarray, *, seed: int) -> np.ndarray | None:
        """Return (K, n) configurations from start to goal, or None if no path is found."""
        util.RNG.setSeed(seed + 1)  # 0 is no seed
        problem, ends = base.ProblemDefinition(self._info), (self._state(start), self._state(goal))
        # Scaling rounds the ends, which may put them into collision.
        if not all(self._info.isValid(end) for end in ends):
            return None
        problem.setStartAndGoalStates(*ends)
        planner = geometric.RRTConnect(self._info)
        planner.setRange(MAX_EDGE_M)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(lambda: self._checks >= MAX_CHECKS))
        if not problem.hasExactSolution():
            return None
        path = problem.getSolutionPath()
        limit = self._checks + MAX_SIMPLIFICATION_CHECKS
        enough = base.PlannerTerminationCondition(lambda: self._checks >= limit)
        geometric.PathSimplifier(self._info).simplify(path, enough)
        return np.array([start, *(self._angles(state) for state in path.getStates()[1:-1]), goal])

    def _is_free(self, state: base.State) -> bool:
        self._checks += 1
        met = self._touches(self._angles(state))
        self.met.update(met)
        return not met

    def _state(self, q: np.ndarray) -> base.State:
        state = self._info.allocState()
        for joint, value in enumerate(q * self._levers):
            state[joint] = float(value)
        return state

    def _angles(self, state: base.State) -> np.ndarray:
        return np.array([state[joint] for joint in range(self._n)]) / self._levers
