"""Whether an object can be grasped where it is, if need be after dragging or turning it; if not, why not."""

from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell
from sim.skills.drag import find_drag
from sim.skills.grasp_choice import choose_grasp
from sim.skills.regrasp import find_regrasp


def ungraspable_because(cell: Workcell, obj: str) -> str | None:
    """Return why the hand cannot grasp an object where it is, even with other objects moved away; None if it can.

    The text continues a sentence that begins with the object's name.
    """
    pose = cell.observe(obj)
    try:
        choose_grasp(cell, obj, pose, pose.yaw, None)
        return None
    except SimulationError as error:
        failure = error
    fixtures = failure.by if isinstance(failure, BlockedError) else ()
    if any(name in cell.scene.shapes for name in fixtures):
        return None
    if find_regrasp(cell, obj, pose, None) is not None or (fixtures and find_drag(cell, obj, pose) is not None):
        return None
    if fixtures:
        return f"leaves no room for the fingers beside {' and '.join(fixtures)}"
    return str(failure).removeprefix(f"{obj} ")
