"""Inverse kinematics of an arm by damped least squares, and by mink where limits are active."""

import itertools
from collections.abc import Container, Iterator, Sequence

import daqp
import mink
import mujoco
import numpy as np
from scipy.linalg.lapack import dposv

from sim.errors import SimulationError, in_metres
from sim.motion.reach import Reach
from sim.motion.trajectory import ToolPose, wrap
from sim.robots.robot import Robot

POSITION_TOLERANCE_M = 0.001
"""Greatest position error of the tool at the end of a movement, m."""

ANGLE_TOLERANCE_RAD = 0.005
"""Greatest orientation error of the tool at the end of a movement, rad."""

FRAME_COST = 10.0
"""Cost of the tool's position error, per m."""

TURN_COST = 3.0
"""Cost of the tool's orientation error, per rad."""

POSTURE_COST = 2e-2
"""Cost of the posture error, per rad: the posture only determines the elbow."""

FRAME_WEIGHTS = np.repeat([[FRAME_COST**2], [TURN_COST**2]], 3, axis=0)
"""(6, 1) weights of the squared errors of the tool along and about the axes."""

JOINT_MARGIN_RAD = 0.01
"""Distance of references from the joints' position limits, rad."""

MAX_GOAL_STEPS = 60
"""Greatest number of IK steps to a goal; usually about 7 are needed."""

MAX_SEARCH_STEP_RAD = 0.6
"""Greatest turn of a joint in an IK step, rad."""

CONVERGED_RAD = 1e-3
"""Greatest turn of a joint in the last IK step, rad: the error that remains is a thousandth of this."""

STALLED_STEPS = 12
"""Number of successive IK steps without progress after which a search fails."""

LEAST_PROGRESS = 0.01
"""Share by which a step must reduce the least error so far to count as progress."""

TILTED_MARGIN_RAD = 0.06
"""Distance of the goals of a tilted hand from the joints' position limits, rad: commands lead the joints."""

MAX_KNOWN = 10_000
"""Greatest number of cached solutions of inverse kinematics."""

MAX_FREE_STEPS = 200
"""Greatest number of steps of the search that ignores the joints' ranges (`missing_turns`)."""

FREE_DAMPING = 1e-3
"""Damping of the steps of this search."""

MAX_FREE_TURN_RAD = 0.3
"""Greatest turn of a joint in a step of this search, rad."""

ELBOW_SWINGS_RAD = (1.4, -1.4, 0.7, -0.7, 2.1, -2.1)
"""Swings of the elbow from home in other IK seeds: turns of the joint that turns most as the tool stays, rad."""

MIN_VERTICAL_COMPONENT = 0.999
"""Least vertical component of the axis of a joint that turns the arm or the tool about the vertical."""


class InverseKinematics:
    """Configurations q, (n,) rad or m, of a robot's arm that bring its tool to a pose; `model` is of the arm alone."""

    def __init__(self, robot: Robot) -> None:
        """Compile the robot's arm."""
        self.model, self.robot = robot.kinematics, robot
        self._configuration = mink.Configuration(self.model)
        self._frame = mink.FrameTask(robot.tool, "site", position_cost=FRAME_COST, orientation_cost=TURN_COST)
        self._site = self.model.site(robot.tool).id
        self._tool = self._configuration.data.site(robot.tool)
        # Targets of the tool, a quaternion and a position, m, and of the posture, (n,) rad.
        self._target, self._rest = np.empty(7), robot.home
        self._posture_normal = POSTURE_COST**2 * np.eye(self.model.nv)
        self._posture = mink.PostureTask(self.model, cost=POSTURE_COST)
        self._limits = [
            mink.ConfigurationLimit(self.model, min_distance_from_limits=JOINT_MARGIN_RAD),
            mink.VelocityLimit(self.model, dict(zip(robot.joints, robot.velocity_limits, strict=True))),
        ]
        self._low, self._high = self.model.jnt_range.T + np.array([[JOINT_MARGIN_RAD], [-JOINT_MARGIN_RAD]])
        self._known: dict[tuple[bytes, bytes, bytes], tuple[np.ndarray, float] | None] = {}
        self._home = self.tool(robot.home)
        self._middle = self.model.jnt_range[-1].mean()
        self._is_hinge = self.model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
        upright = self._configuration.data.xaxis[:, 2]
        self._turns = np.where(self._is_hinge & (np.abs(upright) > MIN_VERTICAL_COMPONENT), np.sign(upright), 0.0)
        self._reach = Reach.of(self.model, robot.home, robot.tool)
        self._home_bearing = self._bearing(self._home)
        self._elbows = np.outer([0.0, *ELBOW_SWINGS_RAD], self._swing())

    def tool(self, q: np.ndarray) -> ToolPose:
        """Return the tool's pose at a configuration."""
        data = self._configuration.data
        data.qpos[:] = q
        mujoco.mj_kinematics(self.model, data)
        return ToolPose(self._tool.xpos.copy(), self._tool.xmat.reshape(3, 3).copy())

    def reach(
        self, goals: Sequence[ToolPose], *, near: np.ndarray | None = None, margin: float = TILTED_MARGIN_RAD
    ) -> tuple[np.ndarray, ToolPose]:
        """Return the first of the `configurations` that bring the tool to one of several poses, and that pose.

        Raises:
            SimulationError: no configuration does.
        """
        for q, k in self.configurations(goals, near=near, margin=margin):
            return q, goals[k]
        raise _unreachable(goals)

    def within_reach(self, goals: Sequence[ToolPose]) -> Sequence[ToolPose]:
        """Return the poses that `Reach` does not exclude; raise `SimulationError` if it excludes all of them."""
        near = [goal for goal in goals if not self._reach.excludes(goal)]
        if not near:
            raise _unreachable(goals)
        return near

    def configurations(
        self,
        goals: Sequence[ToolPose],
        *,
        near: np.ndarray | None = None,
        margin: float = TILTED_MARGIN_RAD,
        without: Container[int] = (),
    ) -> Iterator[tuple[np.ndarray, int]]:
        """Yield configurations that bring the tool to one of several poses, with its number, preferred ones first.

        If the hand points down, they depend on the goals alone, so the elbow cannot drift from goal to goal: the search
        starts from home turned towards the goal and stays in this vertical plane. The pose whose seed has the last
        joint nearest to the middle of its range is tried first. Then the elbow swings aside, as it must near the base.

        Args:
            goals: acceptable poses.
            near: (n,) first seed if the hand does not point down, rad.
            margin: least distance from the joints' position limits if the hand does not point down, rad.
            without: numbers of poses to leave out; the caller may add some between two configurations.
        """
        down = all(goal.points_down for goal in goals)
        if near is not None and not down:
            found = [(q, k) for k, goal in enumerate(goals) if (q := self.nearby(goal, near, margin)) is not None]
            found.sort(key=lambda entry: float(np.abs(entry[0] - near).max()))
            yield from ((q, k) for q, k in found if k not in without)
        turned = [(self._seed(goal), k) for k, goal in enumerate(goals)]
        turned.sort(key=lambda entry: float(abs(entry[0][-1] - self._middle)))
        for offset, (seed, k) in itertools.product(self._elbows, turned):
            if k in without:
                continue
            q = self.nearby(goals[k], np.clip(seed + offset, *self.model.jnt_range.T), margin)
            if q is not None:
                yield q, k

    def _seed(self, goal: ToolPose) -> np.ndarray:
        """Return home with the first joint turned towards the flange and the last to the yaw of a pose, if vertical."""
        q = self.robot.home.copy()
        first, last = self._turns[[0, -1]]
        turn = self._bearing(goal) - self._home_bearing
        q[0] += first * turn
        if last and len(q) > 1:
            q[-1] += last * (goal.yaw - self._home.yaw - abs(first) * turn)
            q[-1] = self._middle + wrap(q[-1] - self._middle)
        return q

    def _bearing(self, pose: ToolPose) -> float:
        """Return the bearing from the base of the point on the hand's axis beside the flange, rad."""
        return self.robot.polar(pose.ahead(float(self._reach.flange[2])))[1]

    def nearby(self, goal: ToolPose, seed: np.ndarray, margin: float = TILTED_MARGIN_RAD) -> np.ndarray | None:
        """Return a configuration that brings the tool to a pose, searched from a seed; None if the search fails.

        Grasps that differ only in the hand's opening have the same pose, so solutions are cached.
        """
        question = goal.position.tobytes(), goal.rotation.tobytes(), seed.tobytes()
        if question not in self._known:
            if len(self._known) >= MAX_KNOWN:
                self._known.clear()
            self._known[question] = self._search(goal, seed)
        found = self._known[question]
        return found[0] if found and found[1] > (0.0 if goal.points_down else margin) else None

    def _search(self, goal: ToolPose, seed: np.ndarray) -> tuple[np.ndarray, float] | None:
        """Search for a solution, see `nearby`; return it with its distance from the joints' position limits, rad."""
        if self._reach.excludes(goal):
            return None
        self._configuration.update(seed)
        self._aim(goal.position, goal.rotation, seed)
        least, stalled = np.inf, 0
        for _ in range(MAX_GOAL_STEPS):
            step, error = self._search_step()
            least, stalled = (error, 0) if error < (1 - LEAST_PROGRESS) * least else (least, stalled + 1)
            if stalled == STALLED_STEPS:
                return None
            self._configuration.update(self._configuration.data.qpos + step)
            if np.abs(step).max() < CONVERGED_RAD:
                break
        if not self._arrived():
            return None
        q, (low, high) = self._configuration.q, self.model.jnt_range.T
        return q, float(np.minimum(q - low, high - q).min())

    def _search_step(self) -> tuple[np.ndarray, float]:
        """Return a step (n,) of a search, rad, and the weighted error of the tool before it.

        It is the least-squares step, of limited length. If that leaves the joints' ranges, it is the best step within
        the ranges in which each joint moves by at most what its velocity limit allows in a second.
        """
        normal, pull, error = self._normal_equations()
        _, step, _ = dposv(normal, pull)  # a tenth of the time of np.linalg.solve
        step *= MAX_SEARCH_STEP_RAD / max(MAX_SEARCH_STEP_RAD, float(np.abs(step).max()))
        q = self._configuration.data.qpos
        if not self._within_ranges(q + step):
            most = self.robot.velocity_limits
            low, high = np.clip(self._low - q, -most, most), np.clip(self._high - q, -most, most)
            step = daqp.solve(normal, -pull, np.empty((0, len(q))), high, low, np.zeros(len(q), dtype=np.intc))[0]
        return step, float(np.linalg.norm(error * np.sqrt(FRAME_WEIGHTS[:, 0])))

    def missing_turns(self, goal: ToolPose) -> dict[str, float]:
        """Return by how much joints would have to exceed their ranges for the tool to reach a pose, rad or m, by name.

        Empty if the tool does not reach the pose even so, or if no joint exceeds its range. The search is from home and
        ignores the ranges.
        """
        model, data = self.model, self._configuration.data
        self._configuration.update(self.robot.home)
        self._aim(goal.position, goal.rotation, self.robot.home)
        for _ in range(MAX_FREE_STEPS):
            if self._arrived():
                break
            jacobian, error = self._frame_residual()
            step = np.linalg.solve(jacobian.T @ jacobian + FREE_DAMPING * np.eye(model.nv), jacobian.T @ error)
            step *= MAX_FREE_TURN_RAD / max(MAX_FREE_TURN_RAD, float(np.abs(step).max()))
            self._configuration.update(data.qpos + step)
        else:
            return {}
        low, high = model.jnt_range.T
        whole = np.where(self._is_hinge, 2 * np.pi, 0.0)
        q = data.qpos - whole * np.round((data.qpos - (low + high) / 2) / (2 * np.pi))
        beyond = np.maximum(np.maximum(low - q, q - high), 0.0)
        return {name: float(excess) for name, excess in zip(self.robot.joints, beyond, strict=True) if excess > 0}

    def _swing(self) -> np.ndarray:
        """Return the (n,) turns of the joints at home that move the tool least; the greatest is 1."""
        self._configuration.update(self.robot.home)
        self._aim(self._home.position, self._home.rotation, self.robot.home)
        jacobian, _ = self._frame_residual()
        least = np.linalg.svd(jacobian)[2][-1]
        return np.asarray(least / least[np.abs(least).argmax()])

    def _aim(self, position: np.ndarray, rotation: np.ndarray, rest: np.ndarray) -> None:
        """Set the targets: a (3,) position, m, and (3, 3) axes of the tool, and the posture, (n,) rad."""
        mujoco.mju_mat2Quat(self._target[:4], rotation.ravel())
        self._target[4:] = position
        self._rest = rest

    def _arrived(self) -> bool:
        _, error = self._frame_residual()
        shift, turn = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
        return bool(shift < POSITION_TOLERANCE_M and turn < ANGLE_TOLERANCE_RAD)

    def _step(self) -> np.ndarray:
        """Return the (n,) step of the joints towards the targets, rad.

        The least-squares problem without limits is solved first, in a third of mink's time. If the step leaves the
        joints' ranges, mink solves the problem with the ranges, and with what the velocity limits allow in a second.
        """
        normal, pull, _ = self._normal_equations()
        _, step, _ = dposv(normal, pull)
        if self._within_ranges(self._configuration.data.qpos + step):
            return np.asarray(step)
        self._frame.set_target(mink.SE3(wxyz_xyz=self._target))
        self._posture.set_target(self._rest)
        try:
            return mink.solve_ik(self._configuration, [self._frame, self._posture], 1.0, "daqp", limits=self._limits)
        except mink.NoSolutionFound:
            raise SimulationError("the arm cannot move on within the limits of its joints") from None

    def _normal_equations(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the (n, n) matrix and (n,) vector of the least-squares step, and the (6,) error of the tool."""
        jacobian, error = self._frame_residual()
        weighted = (jacobian * FRAME_WEIGHTS).T
        normal = weighted @ jacobian + self._posture_normal
        pull = weighted @ error + POSTURE_COST**2 * (self._rest - self._configuration.data.qpos)
        return normal, pull, error

    def _within_ranges(self, q: np.ndarray) -> bool:
        return bool(((q > self._low) & (q < self._high)).all())

    def _frame_residual(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the (6, n) Jacobian and the (6,) error of the tool, m and rad; takes a fifth of mink's time."""
        data, jacobian = self._configuration.data, np.empty((6, self.model.nv))
        mujoco.mj_jacSite(self.model, data, jacobian[:3], jacobian[3:], self._site)
        here, turn, error = np.empty(4), np.empty(4), np.empty(6)
        mujoco.mju_mat2Quat(here, data.site_xmat[self._site])
        mujoco.mju_negQuat(here, here)
        mujoco.mju_mulQuat(turn, self._target[:4], here)
        mujoco.mju_quat2Vel(error[3:], turn, 1.0)
        error[:3] = self._target[4:] - data.site_xpos[self._site]
        return jacobian, error


def _unreachable(goals: Sequence[ToolPose]) -> SimulationError:
    how = "point down" if all(goal.points_down for goal in goals) else "bring its hand there"
    return SimulationError(f"the arm cannot {how} at {in_metres(goals[0].position)} within the limits of its joints")
