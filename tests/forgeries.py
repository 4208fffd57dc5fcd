"""Forgeries of logs, and the check that refutes each: what `prefplan verify` promises at its levels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import mujoco
import numpy as np
from forged_logs import claiming, cut, moved, telling, without_action

from sim.evidence.log import ARRAYS, Log
from sim.evidence.replay import RecordedWorld
from sim.simulation.recorder import STATE
from sim.simulation.run import Event


class Forgery(NamedTuple):
    """What is forged, how, and the name of the check that refutes it."""

    what: str
    forge: Callable[[Log], Log]
    check: str


def scaled(name: str, factor: Any) -> Callable[[Log], Log]:
    return lambda log: replace(log, **{name: getattr(log, name) * factor})


def changed(name: str, frame: float, column: int, value: float) -> Callable[[Log], Log]:
    """Return a forgery of one number, at a share of the log's frames."""

    def forge(log: Log) -> Log:
        rows = getattr(log, name).copy()
        rows[int(frame * len(rows)), column] += value
        return replace(log, **{name: rows})

    return forge


def setting(**changes: Any) -> Callable[[Log], Log]:
    return lambda log: telling(log, setting=log.about.setting | changes)


def telling_of(kind: str, **detail: Any) -> Callable[[Log], Log]:
    """Return a forgery that adds an event at the end."""
    return lambda log: telling(log, events=(*log.about.events, Event(float(log.times[-1]), kind, detail)))


def action(before: str, after: str) -> Callable[[Log], Log]:
    def forge(log: Log) -> Log:
        actions = tuple(replace(a, action=after) if a.action == before else a for a in log.about.actions)
        assert actions != log.about.actions
        return telling(log, actions=actions)

    return forge


def rewritten(before: str, after: str) -> Callable[[Log], Log]:
    """Return a forgery of the scenario."""

    def forge(log: Log) -> Log:
        text = log.about.text.replace(before, after)
        assert text != log.about.text
        return telling(log, text=text)

    return forge


def cheaper(log: Log) -> Log:
    """Return a log in which every transit costs nothing, told without a contradiction."""
    log = rewritten("transit = 3", "transit = 0")(log)
    actions = tuple(replace(a, cost=0 if a.action.startswith("transit") else a.cost) for a in log.about.actions)
    total = sum(a.cost for a in actions)
    return claiming(telling(log, actions=actions), cost=total, task_costs={"tidy": total})


def grasped_for_nothing(log: Log) -> Log:
    return telling(log, actions=tuple(replace(a, cost=0) if a.action == "grasp cup" else a for a in log.about.actions))


def left_out(*numbers: int) -> Callable[[Log], Log]:
    """Return a forgery that leaves actions out, counted from 1, and claims the lower costs."""

    def forge(log: Log) -> Log:
        for number in sorted(numbers, reverse=True):
            log = without_action(log, number)
        total = sum(a.cost for a in log.about.actions)
        return claiming(log, cost=total, task_costs={"tidy": total})

    return forge


def in_turn(*forgeries: Callable[[Log], Log]) -> Callable[[Log], Log]:
    def forge(log: Log) -> Log:
        for each in forgeries:
            log = each(log)
        return log

    return forge


def fault(text: str, time: float, **about: Any) -> Callable[[Log], Log]:
    """Return a forgery that invents a fault, asked for and told, at a time."""

    def forge(log: Log) -> Log:
        told = sorted([*log.about.events, Event(time, "fault", {"fault": text} | about)], key=lambda event: event.time)
        return telling(setting(faults=[*log.about.setting["faults"], text])(log), events=tuple(told))

    return forge


def intervention(obj: str, time: float, *, position: Sequence[float] | None = None, velocity: float = 0.0) -> Any:
    """Return a forgery that sets an object's state from outside, and leaves it there in all later frames."""

    def forge(log: Log) -> Log:
        world = RecordedWorld(log)
        data, joint = mujoco.MjData(world.mujoco), world.mujoco.joint(obj)
        frame = world.frame_at(time)
        data.qpos[:], data.qvel[:], data.time = log.qpos[frame], log.qvel[frame], time
        first, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        if position is not None:
            data.qpos[first : first + 7] = [*position, 1, 0, 0, 0]
            log = moved(log, obj, tuple(position), since=time)
        data.qvel[dof : dof + 6] = velocity
        state = np.empty(mujoco.mj_stateSize(world.mujoco, STATE))
        mujoco.mj_getState(world.mujoco, data, state, STATE)
        row = np.array([[round(time / world.mujoco.opt.timestep), *state]])
        return replace(log, interventions=np.vstack([log.interventions, row]))

    return forge


def drifting(obj: str, since: float, velocity: Sequence[float], seconds: float) -> Callable[[Log], Log]:
    """Return a forgery in which an object moves evenly by itself for a while; its velocity is told, too."""

    def forge(log: Log) -> Log:
        world = RecordedWorld(log)
        first, dof = log.about.joints[obj], int(world.mujoco.joint(obj).dofadr[0])
        qpos, qvel = log.qpos.copy(), log.qvel.copy()
        spent = np.clip(log.times - since, 0, seconds)
        qpos[:, first : first + 3] += spent[:, None] * np.array(velocity)
        qvel[(spent > 0) & (spent < seconds), dof : dof + 3] += velocity
        return replace(log, qpos=qpos, qvel=qvel)

    return forge


def shifted(name: str, obj: str, by: float, *, since: float = -1.0) -> Callable[[Log], Log]:
    """Return a forgery in which a joint's first value differs, from a time on."""

    def forge(log: Log) -> Log:
        rows = getattr(log, name).copy()
        rows[log.times > since, log.about.joints[obj]] += by
        return replace(log, **{name: rows})

    return forge


def frames_cut_out(log: Log) -> Log:
    keep = (log.times < 2) | (log.times > 2.5)
    return replace(log, **{name: getattr(log, name)[keep] for name in ARRAYS})


def stopped_early(log: Log) -> Log:
    """Return a log that ends with its second action, and tells of no more."""
    done = log.about.actions[:2]
    return telling(cut(log, done[-1].end), actions=done)


def appears_at_its_goal(log: Log) -> Log:
    """Return a log in which the cup stays where it starts until the last moment."""
    rows, first = log.qpos.copy(), log.about.joints["cup"]
    rows[log.times < log.times[-1] - 0.3, first : first + 7] = log.qpos[0, first : first + 7]
    return replace(log, qpos=rows)


OPEN = np.array([0, 0, 0, 0, 0, 0, 0, 10**6])

PLAIN = (
    Forgery("commands all zero", scaled("controls", 0), "simulated again"),
    Forgery(
        "the second half of the commands missing",
        lambda log: replace(log, controls=log.controls[:1500]),
        "simulated again",
    ),
    Forgery("the gripper commanded open", lambda log: replace(log, controls=log.controls + OPEN), "simulated again"),
    Forgery("a joint past its stop", shifted("qpos", "joint4", -2.0), "joint positions"),
    Forgery("velocities all zero", scaled("qvel", 0), "simulated again"),
    Forgery("a grip of 100 kN told", telling_of("grasped", object="cup", force=[1e5, 1e5]), "events"),
    Forgery("another seed", setting(seed=5), "faults"),
    Forgery("no seed", setting(seed=None), "faults"),
    Forgery("another perturbation", setting(perturbation="position=8,angle=5"), "faults"),
    Forgery("the cup 3 mm aside throughout", shifted("qpos", "cup", 0.003), "simulated again"),
    Forgery(
        "the cup at its goal from 2 s on",
        lambda log: moved(log, "cup", (0.45, -0.1, 0.0225), since=2.0),
        "simulated again",
    ),
    Forgery("the cup in its place until the end", appears_at_its_goal, "action 2"),
    Forgery("the cup floats up", drifting("cup", 0.5, (0, 0, 0.2), 0.3), "simulated again"),
    Forgery("the cup slides by itself", drifting("cup", 0.2, (0.0, 0.6, 0), 0.3), "simulated again"),
    Forgery("the cup sinks into the desk by 3 mm", drifting("cup", 0.2, (0, 0, -0.06), 0.05), "simulated again"),
    Forgery("an arm that leaps", shifted("qpos", "joint7", 0.05, since=3.0), "simulated again"),
    Forgery("another object's grasp", action("grasp cup", "grasp tray"), "contacts"),
    Forgery("a transit elsewhere", action("transit desk", "transit tray"), "action 1"),
    Forgery("a transit to nowhere", action("transit desk", "transit spot1"), "action 1"),
    Forgery(
        "the cup still moves at the end",
        lambda log: drifting("cup", float(log.times[-1]) - 0.15, (0.1, 0, 0), 1.0)(log),
        "rest",
    ),
    Forgery("a grasp that costs nothing", grasped_for_nothing, "action 2"),
    Forgery("another start in the scenario", rewritten('start = "desk"', 'start = "tray"'), "faults"),
    Forgery("a harder formula in the scenario", rewritten("F cup_tray", "F (cup_tray & cup_desk)"), "completed"),
    Forgery("an action left out", lambda log: without_action(log, 1), "total cost"),
    Forgery("a transit left out", left_out(1), "action 1"),
    Forgery("a transport left out", left_out(3), "action 3"),
    Forgery(
        "a transit left out after a surprise that there was not",
        in_turn(
            lambda log: telling(log, events=(Event(0.0, "replan", {}), *log.about.events)),
            left_out(1),
        ),
        "action 1",
    ),
    Forgery("frames cut out", frames_cut_out, "simulated again"),
    Forgery("frames in reverse", lambda log: replace(log, times=log.times[::-1].copy()), "simulated again"),
    Forgery("frames and actions cut off", stopped_early, "completed"),
    Forgery("frames cut off", lambda log: cut(log, 3.0), "action 4"),
    Forgery("a cheaper task claimed", lambda log: claiming(log, task_costs={"tidy": 3}), "task cost tidy"),
    Forgery(
        "an easier formula",
        lambda log: telling(log, text=log.about.text.replace("F cup_tray", "true")),
        "task cost tidy",
    ),
    Forgery(
        "a task claimed that there is not", lambda log: claiming(log, task_costs={"tidy": 10, "peace": 0}), "task peace"
    ),
    Forgery("a cost without end claimed", lambda log: claiming(log, cost=10**400), "total cost"),
    Forgery("a fault that there is not", fault("teleport:cup@1", 1.0), "faults"),
    Forgery("a fault due at no number", fault("slip@²", 1.0), "faults"),
    Forgery("a leap by a move nobody asked for", in_turn(fault("move:cup@1", 1.0), setting(faults=[])), "faults"),
    Forgery("a move that changes nothing", fault("move:cup@1", 1.0), "faults"),
    Forgery("a knock that changes nothing", fault("knock:cup@1", 1.0), "faults"),
    Forgery("a stranger that is not there", fault("foreign:tray@1", 1.0, object="foreign1"), "faults"),
    Forgery("a slip of nothing", fault("slip@1", 0.5), "faults"),
    Forgery("a slip from a closed hand", fault("slip@3", 3.4), "faults"),
    Forgery("a miss before a grasp that succeeds", fault("miss:1@1", 0.5), "faults"),
    Forgery("a fault before it is due", fault("blind:1@4", 0.5), "faults"),
    Forgery(
        "a leap that a knock excuses",
        in_turn(intervention("cup", 1.0, position=(0.45, -0.1, 0.0225)), fault("knock:cup@1", 1.0)),
        "faults",
    ),
    Forgery(
        "a task done by a move into the air",
        in_turn(intervention("cup", 1.0, position=(0.45, -0.1, 0.2)), fault("move:cup@1", 1.0)),
        "simulated again",
    ),
    Forgery("a push from outside, not told", intervention("cup", 1.0, velocity=0.5), "faults"),
)
"""Refuted with default options, also in a log that names another version of MuJoCo; the run carries a cup from a
desk to a tray in four actions."""

SCENARIO = (
    Forgery("an easier formula", rewritten("F cup_tray", "F cup_desk | F cup_tray"), "scenario"),
    Forgery("cheaper costs", cheaper, "scenario"),
    Forgery("another preference", rewritten('kind = "order"\n', 'kind = "max"\n'), "scenario"),
)
"""Refuted in the scenario; without it, they are not proved."""

RESIMULATED = (
    Forgery("the cup 3 mm aside for a while", shifted("qpos", "cup", 0.003, since=0.5), "simulated again"),
    Forgery("a command changed by 0.1 mrad", changed("controls", 0.3, 3, 1678), "simulated again"),
    Forgery("a velocity changed", changed("qvel", 0.5, 2, 1e-4), "simulated again"),
    Forgery("more friction", setting(perturbation="position=5,angle=5,friction=0.5"), "simulated again"),
    Forgery(
        "another version of MuJoCo, and the cup 3 mm aside",
        in_turn(
            lambda log: telling(log, versions=log.about.versions | {"mujoco": "3.0.0"}),
            shifted("qpos", "cup", 0.003, since=0.5),
        ),
        "simulated again",
    ),
)
"""Refuted in an equal environment; in another one, they are not proved."""
