"""The Panda of MuJoCo Menagerie: its bodies, meshes and gains, with the fingers' shapes of the built-in Panda."""

from dataclasses import fields

import mujoco

from prefplan.models.manipulation.surroundings import GripperSetup
from sim.geometry.mjcf import HIDDEN
from sim.robots.arms.panda import MJCF, PANDA
from sim.robots.import_mjcf import ImportedArm
from sim.robots.menagerie import menagerie_mjcf, unavailable_because
from sim.robots.robot import ArmConstants, check_parts

FINGERS = ("left_finger", "right_finger")


def menagerie_panda_mjcf() -> mujoco.MjSpec:
    """Return the arm with the built-in Panda's tool and shapes of the fingers, whose pads are single boxes."""
    spec, own = menagerie_mjcf("panda_mj_description"), mujoco.MjSpec.from_file(str(MJCF))
    check_parts(spec, body=("hand", *FINGERS))
    for name in FINGERS:
        for geom in spec.body(name).geoms:
            if geom.contype or geom.conaffinity:
                spec.delete(geom)
        for shape in own.body(name).geoms:
            geom = spec.body(name).add_geom(name=shape.name, type=shape.type, size=shape.size, pos=shape.pos)
            geom.group, geom.friction = HIDDEN, shape.friction
    spec.body("hand").add_site(name=PANDA.tool, pos=own.site(PANDA.tool).pos)
    return spec


MENAGERIE_PANDA = ImportedArm(
    **{field.name: getattr(PANDA, field.name) for field in fields(ArmConstants)}
    | {
        "name": "menagerie",
        "title": "the same arm and hand, of MuJoCo Menagerie",
        "unavailable_because": unavailable_because,
    },
    mjcf=menagerie_panda_mjcf,
    # The built-in Panda's force.
    gripper=GripperSetup("parallel", "actuator8", force=15.0, open=0.08),
)
