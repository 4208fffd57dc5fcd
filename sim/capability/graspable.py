"""Whether an object can be grasped where it is, if need be after dragging or turning it; if not, why not."""

from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell
from sim.skills.drag import find_drag
from sim.skills.grasp_choice import choose_grasp
from sim.skills.hand import frame_of
from sim.skills.regrasp import find_regrasp
from sim.world.grasps import ranked


def ungraspable_because(cell: Workcell, obj: str) -> str | None:
    """Return why the hand cannot grasp an object where it is, even with other objects moved away; None if it can.

    The text continues a sentence that begins with the object's name.
    """
    pose, fixtures = cell.observe(obj), tuple[str, ...]()
    try:
        choose_grasp(cell, obj, pose, pose.yaw, None)
        return None
    except BlockedError as error:
        if any(name in cell.scene.shapes for name in error.by):
            return None
        fixtures = error.by
    except SimulationError:
        pass  # out of reach
    if find_regrasp(cell, obj, pose, None) is not None or (fixtures and find_drag(cell, obj, pose) is not None):
        return None
    if fixtures:
        return f"leaves no room for the fingers beside {' and '.join(fixtures)}"
    if next(ranked(pose.shape, cell.scene.robot.gripper, frame_of(pose, pose.yaw)), None) is None:
        return "lies so that no grasp can pick it up and set it upright"
    return "is out of reach"
