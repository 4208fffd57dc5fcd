"""Whether an object can be grasped where it is, if need be after dragging or turning it; if not, why not."""

from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell
from sim.skills.drag import find_drag
from sim.skills.grasp_choice import ranked
from sim.skills.hand import frame_of, free_pose
from sim.skills.regrasp import find_regrasp


def ungraspable_because(cell: Workcell, obj: str) -> str | None:
    """Return why the hand cannot grasp an object where it is, even with other objects moved away; None if it can.

    The text continues a sentence that begins with the object's name.
    """
    pose = cell.observe(obj)
    frame = frame_of(pose, pose.yaw)
    options, fixtures = tuple(ranked(cell, obj, frame)), set[str]()
    for grasp in options:
        try:
            free_pose(cell, grasp.at(pose.position, frame).symmetric_poses(), grasp, obj, near=cell.reference)
        except BlockedError as error:
            if any(name in cell.scene.shapes for name in error.by):
                return None
            fixtures.update(error.by)
        except SimulationError:
            continue
        else:
            return None
    if find_regrasp(cell, obj, pose, None) is not None or (fixtures and find_drag(cell, obj, pose) is not None):
        return None
    if fixtures:
        return f"leaves no room for the fingers beside {' and '.join(sorted(fixtures))}"
    if not options:
        return "lies so that no grasp can pick it up and set it upright"
    return "is out of reach"
