"""Miss: the fingers get no grip on the object."""

import re
from collections.abc import Callable, Sequence

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.operators import Grasp
from prefplan.models.manipulation.symbolic import Action
from sim.execution.faults.fault import Fault, Injection
from sim.simulation.workcell import Workcell
from sim.skills.skill import Skill

MAX_MISSES = 2
"""Greatest random number of grasps in a row that miss: fewer than the robot tries."""

GIVING_WAY_M = 0.004
"""By how much the fingers open when they touch the object, m."""


class Miss(Fault):
    """In the next grasps, the fingers give way when they touch the object."""

    kind = "miss"
    noun = "N"
    grasps = True

    @classmethod
    def candidates(cls, model: ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
        """See `Fault.candidates`."""
        return [str(rng.integers(1, MAX_MISSES, endpoint=True))]

    def objection(self, model: ManipulationModel) -> str | None:
        """See `Fault.objection`."""
        if re.fullmatch("0*[1-9][0-9]*", self.argument):
            return None
        return f"{self.argument!r} does not say how many grasps are missed, as in {self.form()}"

    def inject(self, injection: Injection) -> dict[str, str]:
        """See `Fault.inject`."""
        injection.skills["grasp"] = _WithoutGrip(injection.skills["grasp"], injection.cell, int(self.argument))
        return {}


class _WithoutGrip(Grasp, Skill):
    """A grasping skill without grip the first few times that it is performed in a cell; rehearsals use other cells."""

    def __init__(self, skill: Skill, cell: Workcell, times: int) -> None:
        self._skill, self._cell, self._times = skill, cell, times

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """See `Skill.perform`."""
        hold = cell.gripper
        if self._times and cell is self._cell:
            self._times -= 1
            cell.gripper = _giving_way(cell)
        try:
            self._skill.perform(cell, action, ahead)
        finally:
            cell.gripper = hold


def _giving_way(cell: Workcell) -> Callable[[float], float]:
    """Return a gripper that opens a little when a pad touches the object, and does not close again."""
    hold, gripper = cell.gripper, cell.scene.robot.gripper
    least = -np.inf

    def command(width: float) -> float:
        nonlocal least
        if cell.contacts.pad_forces.any():
            fingers = np.array([cell.data.joint(finger).qpos[0] for finger in gripper.joints])
            least = max(least, gripper.opened(fingers) + GIVING_WAY_M)
        return hold(max(width, least))

    return command
