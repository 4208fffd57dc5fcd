"""Collision checks of the robot and its load, with the world and with each other, at joint angles and along paths."""

import copy
from collections.abc import Collection, Iterable, Mapping

import mujoco
import numpy as np

from sim.geometry.mjcf import is_solid, with_descendants
from sim.motion.trajectory import ToolPose, spaced
from sim.perception.sensors import Poses
from sim.world.contacts import set_margins
from sim.world.scene import Scene

ADJACENT_M = 0.01
"""Margin of each link, m. Links whose margins overlap at home, with the hand closed, never count as in collision."""

CHECK_STEP_M = 0.008
"""Greatest movement of any point of the robot or its load between two checks along a path, m; twice the clearance if
that is more. A body farther away than half of this at both checks is not hit in between, however thin it is."""

LINK_CLEARANCE_M = 0.003
"""Least clearance of the arm's links where a clearance is asked for, m: braking, a stretched arm overshoots by 2 mm."""

LINK_RESERVE_M = 0.0005
"""Clearance added where a single configuration is checked, m: the arm stops a little off the pose that was planned."""

MAX_NEARING_M = 0.001
"""The arm stops within this distance of its goal, m. By so much, it may come nearer to a body within the clearance at
the start, its load may come nearer to its support than at the end, and the load may end in bodies beside it."""

LEAST_LIFT = 0.7
"""Least upward component of the normal of a contact that carries the load."""

MAX_SINK_M = 0.008
"""Greatest depth to which the load may end in its support, m, whose height is observed, too; deeper, a board in the
load's middle may seem to carry it. It may not end as deep in bodies beside it, and never in bodies above it."""

HAND_DEPTH_M = 0.001
"""Least depth at which the hand counts as inside a body (`hand_is_inside`), m: then every solution within the
tolerances of inverse kinematics is in collision, too."""


class CollisionChecker:
    """A copy of the scene in which configurations q of the robot, (n,) rad or m, are checked."""

    def __init__(self, scene: Scene) -> None:
        """Copy the scene, without a held object."""
        self._model = model = copy.copy(scene.mujoco)
        self._data = mujoco.MjData(model)
        self._robot = robot = scene.robot
        self._arm, self._is_finger = robot.qpos(model), robot.fingers(model)
        self._widths = [int(model.joint(name).qposadr[0]) for name in robot.gripper.joints]
        self._own = own = robot.bodies(model)
        # What of the robot is fixed, such as its base, is part of the world: objects may stand against it.
        self._is_robot = (own & (model.body_weldid > 0))[model.geom_bodyid]
        robot.let_links_collide(model)
        self._is_world = ~self._is_robot & is_solid(model)
        self._tool = self._data.site(robot.tool)
        self._hand = with_descendants(model, model.body_weldid[model.site(robot.tool).bodyid[0]])
        self._hand_parts = (
            (np.flatnonzero(self._hand), self._data.xipos, self._data.ximat),
            (np.flatnonzero(self._hand[model.geom_bodyid]), self._data.geom_xpos, self._data.geom_xmat),
        )
        links = [model.joint(name).bodyid[0] for name in robot.joints]
        self._is_link = np.isin(model.geom_bodyid, links) & (model.geom_contype != 0)
        self._object_poses = {obj: self._data.joint(obj).qpos for obj in scene.shapes}
        named = ((str(model.body(body).name), own[body]) for body in range(model.nbody))
        self._names = [f"the robot's {name.rpartition(':')[2]}" if is_own else name for name, is_own in named]
        self._handled = self._load = -1
        self._let_collide()
        self._adjacent: set[tuple[int, int]] = set()
        self._keep(ADJACENT_M)
        robot.put(self._data, robot.home, width=0.0)
        self._place(robot.home)
        met = {tuple(sorted(map(int, model.geom_bodyid[[*pair]]))) for pair in self._pairs(self._data.contact.geom)}
        self._adjacent = {(one, other) for one, other in met if own[[one, other]].all()}
        self._known.clear()

    @property
    def levers(self) -> np.ndarray:
        """(n,) bounds on how far each joint moves a point of the robot, m per rad or m: the reach beyond the joint."""
        model, data = self._model, self._data
        anchors = np.array([data.joint(name).xanchor for name in self._robot.joints])
        links = np.linalg.norm(np.diff(anchors, axis=0), axis=1)
        distal = self._moving[model.geom_bodyid[self._moving] >= model.joint(self._robot.joints[-1]).bodyid[0]]
        beyond = np.linalg.norm(data.geom_xpos[distal] - anchors[-1], axis=1) + model.geom_rbound[distal]
        reach = beyond.max() + np.append(np.cumsum(links[::-1])[::-1], 0.0)
        slides = [model.joint(name).type[0] == mujoco.mjtJoint.mjJNT_SLIDE for name in self._robot.joints]
        return np.where(slides, 1.0, reach)

    def see(
        self,
        now: mujoco.MjData,
        poses: Poses,
        *,
        handled: str | None = None,
        held: bool = False,
        width: float | None = None,
    ) -> None:
        """Set the state of the world for the next checks: joints of the robot, and last observed poses of the objects.

        The fingers may touch the handled object; if it is held, it moves with the hand as its load, which is checked
        for collisions, too. `width` is that between the pads, m; None for the current one.
        """
        model, data = self._model, self._data
        data.qpos[:] = now.qpos
        if width is not None:
            data.qpos[self._widths] = self._robot.gripper.positions(width)
        for obj, pose in poses.items():
            self._put(obj, pose.position, pose.rotation)
        before = self._handled, self._load
        self._handled = model.body(handled).id if handled else -1
        self._load = self._handled if held else -1
        if handled and held:
            tool = now.site(self._robot.tool)
            turn = tool.xmat.reshape(3, 3).T
            self._in_hand = handled, turn @ (poses[handled].position - tool.xpos), turn @ poses[handled].rotation
        if before != (self._handled, self._load):
            self._let_collide()

    def touches(
        self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0
    ) -> frozenset[tuple[str, str]]:
        """Return the collisions at a configuration: names of a body of the robot or the load, and of another body.

        Bodies nearer than `clearance`, m, count as in collision (for links, see `LINK_CLEARANCE_M`). A `width` between
        the pads, m, holds for the next checks, too.
        """
        if width is not None:
            self._data.qpos[self._widths] = self._robot.gripper.positions(width)
        self._keep(clearance, links=LINK_CLEARANCE_M + LINK_RESERVE_M)
        self._place(q)
        body, names = self._model.geom_bodyid, self._names
        return frozenset((names[body[one]], names[body[other]]) for one, other in self._pairs(self._data.contact.geom))

    def distances(self, q: np.ndarray, *, within: float) -> dict[tuple[str, str], float]:
        """Return the distances up to `within`, m, of bodies of the robot or its load from other bodies.

        Of two parts that both move, half the distance is returned: their margins add up (`set_margins`).
        """
        self._keep(within)
        self._place(q)
        contact, names, found = self._data.contact, self._names, dict[tuple[str, str], float]()
        counted = self._pairs(contact.geom)
        if not counted:
            return found
        rows = zip(contact.geom.tolist(), contact.dist.tolist(), contact.includemargin.tolist(), strict=True)
        for (one, other), distance, margin in rows:
            for pair in {(one, other), (other, one)} & counted:
                first, second = (names[self._model.geom_bodyid[geom]] for geom in pair)
                found[first, second] = min(distance * within / margin, found.get((first, second), np.inf))
        return found

    def touches_hand(self, collision: tuple[str, str]) -> bool:
        """Return whether a collision found by `touches` is between the hand and a body that is not of the robot."""
        part, other = (self._names.index(name) for name in collision)
        return bool(self._hand[part] and not self._own[other])

    def hand_is_inside(self, tool: ToolPose, *, width: float) -> bool:
        """Return whether the hand, opened to a width, m, would be inside a body if its tool were at a pose.

        The handled object does not count. The rest of the arm, and whether it reaches the pose, are ignored.
        """
        model, data = self._model, self._data
        data.qpos[self._widths] = self._robot.gripper.positions(width)
        self._keep(0.0)
        mujoco.mj_kinematics(model, data)
        turn = tool.rotation @ self._tool.xmat.reshape(3, 3).T
        shift = tool.position - turn @ self._tool.xpos
        for moved, positions, rotations in self._hand_parts:
            positions[moved] = positions[moved] @ turn.T + shift
            rotations[moved] = (turn @ rotations[moved].reshape(-1, 3, 3)).reshape(-1, 9)
        mujoco.mj_collision(model, data)
        if not data.ncon:
            return False
        pairs = data.contact.geom[data.contact.dist < -HAND_DEPTH_M]
        other = ~self._is_robot & (model.geom_bodyid != self._handled)
        return bool((self._hand[model.geom_bodyid[pairs]] & other[pairs[:, ::-1]]).any())

    def blockers(self, path: np.ndarray, *, clearance: float) -> frozenset[str]:
        """Return the names of the bodies in the first collision along (N, n) configurations; none if there is none.

        A shape that is within the clearance at the start, such as an object that slipped against a finger, counts only
        if the arm comes nearer, comes back after leaving it, or never leaves it. What the load comes to rest on or
        beside at the end of the path counts only where the load is nearer to it than at the end.

        Bodies nearer than a clearance, m, count as in collision. Between rows, the path is linear.
        """
        self._keep(clearance)
        self._place(path[-1])
        carriers = self._carriers(clearance)
        self._place(path[0])
        near = self._met(carriers)
        least = self._nearest(near) - MAX_NEARING_M
        for q in spaced(path, self.levers, step=max(CHECK_STEP_M, 2 * clearance))[1:]:
            self._place(q)
            met = self._met(carriers)
            near &= met
            if met - near:
                return self._owners(met - near)
            if near and self._nearest(near) < least:
                return self._owners(near)
        return self._owners(near)

    def _let_collide(self) -> None:
        """Let the robot and its load collide with the world, and no bodies of the world with each other."""
        model, world = self._model, self._is_world
        self._is_load = is_load = world & (model.geom_bodyid == self._load)
        model.geom_contype[world], model.geom_conaffinity[world] = 1, is_load[world]
        model.body_conaffinity[model.geom_bodyid[world]] = 0
        model.body_conaffinity[model.geom_bodyid[is_load]] = 1
        self._moving = np.flatnonzero(is_load | (self._is_robot & (model.geom_contype != 0)))
        self._known: dict[bytes, frozenset[tuple[int, int]]] = {}
        self._clearances = np.nan, np.nan

    def _keep(self, clearance: float, *, links: float = LINK_CLEARANCE_M) -> None:
        """Set the margins so that contacts within a clearance, m, of the robot and its load are found."""
        if (clearance, links) != self._clearances:
            self._clearances = clearance, links
            margins = np.zeros(self._model.ngeom)
            margins[self._moving] = clearance
            if clearance > 0:
                margins[self._is_link] = max(clearance, links)
            set_margins(self._model, margins)

    def _place(self, q: np.ndarray) -> None:
        """Move the robot and its load, and find the contacts."""
        self._data.qpos[self._arm] = q
        mujoco.mj_kinematics(self._model, self._data)
        if self._load >= 0:
            turn = self._tool.xmat.reshape(3, 3)
            obj, offset, rotation = self._in_hand
            self._put(obj, self._tool.xpos + turn @ offset, turn @ rotation)
            mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)

    def _put(self, obj: str, position: np.ndarray, rotation: np.ndarray) -> None:
        pose = self._object_poses[obj]
        pose[:3] = position
        mujoco.mju_mat2Quat(pose[3:], rotation.ravel())

    def _pairs(self, geoms: np.ndarray) -> frozenset[tuple[int, int]]:
        """Return the pairs of (N, 2) geoms in contact, except for pairs that may touch; cached, as they change rarely.

        The first geom is the one that moves, or that of the body with the lower index if both do. The hand may touch
        its load.
        """
        if (question := geoms.tobytes()) not in self._known:
            bodies, fingers = self._model.geom_bodyid[geoms], self._is_finger[geoms]
            is_load, moves = bodies == self._load, self._is_robot[geoms] | (bodies == self._load)
            allowed = ((bodies == self._handled) & fingers[:, ::-1]) | (is_load & self._hand[bodies[:, ::-1]])
            turned = np.where(moves.all(axis=1), bodies[:, 0] > bodies[:, 1], moves[:, 1])
            counted = moves.any(axis=1) & ~allowed.any(axis=1)
            counted &= np.array([tuple(sorted(pair)) not in self._adjacent for pair in bodies.tolist()], dtype=bool)
            ordered = np.where(turned[:, None], geoms[:, ::-1], geoms)[counted]
            self._known[question] = frozenset(map(tuple, ordered.tolist()))
        return self._known[question]

    def _carriers(self, clearance: float) -> dict[int, float]:
        """Return the geoms within a clearance, m, of the load in its present pose that may carry it or be beside it.

        Each has the least distance from it, m, that the load may have on its path. Empty if none carries the load.
        """
        contact, is_load, found, carried = self._data.contact, self._is_load, dict[int, float](), False
        for (one, other), distance, frame in zip(contact.geom.tolist(), contact.dist, contact.frame, strict=True):
            # The normal points from the first geom to the second.
            carrier, lift = (other, -frame[2]) if is_load[one] else (one, frame[2])
            if is_load[one] == is_load[other] or self._is_robot[carrier] or distance >= clearance:
                continue
            depth = MAX_SINK_M if lift > LEAST_LIFT else MAX_NEARING_M
            if lift > -LEAST_LIFT and distance > -depth:
                found[carrier] = min(found.get(carrier, np.inf), float(distance) - MAX_NEARING_M)
                carried |= lift > LEAST_LIFT
        return found if carried else {}

    def _met(self, carriers: Mapping[int, float]) -> frozenset[int]:
        """Return the geoms within the clearance of the robot or its load, except carriers that the load may touch."""
        contact, is_load = self._data.contact, self._is_load
        geoms = contact.geom
        if carriers:
            counted = [
                is_load[one] == is_load[other] or distance <= carriers.get(other if is_load[one] else one, np.inf)
                for (one, other), distance in zip(geoms.tolist(), contact.dist.tolist(), strict=True)
            ]
            geoms = geoms[np.array(counted, dtype=bool)]
        return frozenset(other for _, other in self._pairs(geoms))

    def _owners(self, geoms: Iterable[int]) -> frozenset[str]:
        return frozenset(self._names[self._model.geom_bodyid[geom]] for geom in geoms)

    def _nearest(self, others: Collection[int]) -> float:
        """Return the least distance in a contact with one of these geoms, m; infinite if there is none."""
        touched = np.isin(self._data.contact.geom, list(others)).any(axis=1)
        return float(np.min(self._data.contact.dist[touched], initial=np.inf))
