"""Friction and stiffness of objects in contact with the table, with a pad or with another object.

Friction depends on both partners of a contact, but MuJoCo takes the larger friction of the two geoms, or the friction
of the geom with the higher priority. So contacts of objects with pads and with one another are declared as pairs with
their own friction. Surfaces that objects lie on have zero friction, so that the object's friction applies.

In MuJoCo, the smaller the mass of the lighter partner, the softer the contact, whatever the load. So contacts of
objects are made stiff enough to carry the heaviest object in the scene.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, product

import mujoco
import numpy as np

from sim.geometry.mjcf import solid_geoms
from sim.world.shapes import ObjectShape

OBJECT_FRICTION = 0.8
"""Sliding friction of two objects."""

HEAVY_IMPEDANCE = 0.85
"""Impedance (`solimp[0]`) of contacts of heavy objects with pads. At equal impedance, a heavier object penetrates less.
At the pads' own 0.95, a contact is sometimes lost for a step, and the Panda's torque rates reach 225 % of their limit
with 3 kg; at 0.85, 49 %. At 0.8, such an object slips down in the hand."""

CARRIED_SHARE = 8.0
"""Load that MuJoCo's usual contacts carry, in masses of the object, which sinks in by less than 1 mm. Contacts are
stiffened only if the heaviest object exceeds this load, since the arm puts an object down harder on a stiffer contact:
with 1, 5 and 12, 61 g beside 2.8 kg make joint 2 reach 139, 98 and 69 % of its torque rate."""


def declare_contacts(
    spec: mujoco.MjSpec,
    shapes: Mapping[str, ObjectShape],
    *,
    pads: Sequence[str],
    supports: Iterable[mujoco.MjsBody],
) -> None:
    """Set the stiffness of the objects' contacts, and their friction with pads, with one another and with supports.

    The keys of `shapes` are the names of the objects' bodies; `supports` are the bodies that objects may lie on.
    """
    for body in supports:
        for geom in body.geoms:
            geom.friction[0] = 0.0
    solids = {name: [geom for geom in spec.body(name).geoms if geom.contype or geom.conaffinity] for name in shapes}
    heaviest = max((shape.mass for shape in shapes.values()), default=0.0)
    for name, parts in solids.items():
        for geom in parts:
            _stiffen(geom, share=min(1.0, CARRIED_SHARE * shapes[name].mass / heaviest))
        for geom, pad in product(parts, pads):
            _declare(spec, geom, spec.geom(pad), impedance=HEAVY_IMPEDANCE if shapes[name].is_heavy else None)
    for parts, others in combinations(solids.values(), 2):
        for geom, other in product(parts, others):
            _declare(spec, geom, other, slide=OBJECT_FRICTION)


def scale_friction(
    model: mujoco.MjModel, objects: Mapping[str, float], *, pads: Mapping[str, float], table: float
) -> None:
    """Multiply the sliding friction of every contact of an object by the factors of both partners.

    `objects` and `pads` have the factors by name; `table` is the factor of every surface that objects lie on.
    """
    factors = np.ones(model.ngeom)
    for name, factor in objects.items():
        factors[solid_geoms(model, name)] = factor
    for name, factor in pads.items():
        factors[model.geom(name).id] = factor
    model.geom_friction[:, 0] *= factors
    model.pair_friction[:, :2] *= (factors[model.pair_geom1] * factors[model.pair_geom2])[:, None]
    for name in objects:
        model.geom_friction[solid_geoms(model, name), 0] *= table


def set_margins(model: mujoco.MjModel, margins: np.ndarray) -> None:
    """Make MuJoCo report contacts of geoms no farther apart than the sum of their (ngeom,) margins, m."""
    model.geom_margin[:] = margins
    model.body_margin[:] = margins.max()
    model.pair_margin[:] = model.geom_margin[model.pair_geom1] + model.geom_margin[model.pair_geom2]


def _stiffen(geom: mujoco.MjsGeom, *, share: float) -> None:
    """Make the contacts of an object as stiff as those of an object of 1 / `share` times its mass.

    Static penetration is proportional to (1 - d) / d, where d is the impedance, and to the load over the lighter mass.
    In a contact with a surface, `solmix` weights the object's impedance against the surface's.
    """
    impedance = np.array(geom.solimp[:2])
    geom.solimp[:2] = impedance / (impedance + (1 - impedance) * share)
    geom.solmix /= share


def _declare(
    spec: mujoco.MjSpec,
    one: mujoco.MjsGeom,
    other: mujoco.MjsGeom,
    *,
    slide: float | None = None,
    impedance: float | None = None,
) -> None:
    """Declare a contact pair with the parameters that MuJoCo would give it, except those that are passed.

    See "Contact parameters" in MuJoCo's documentation. Of geoms of the same priority, the stiffer one decides.
    """
    first = max(one, other, key=lambda geom: (geom.priority, geom.solimp[0]))
    friction, condim = first.friction, first.condim
    if one.priority == other.priority:
        friction, condim = np.maximum(one.friction, other.friction), max(one.condim, other.condim)
    if slide is not None:
        friction = [slide, *friction[1:]]
    solimp = first.solimp if impedance is None else [impedance, *first.solimp[1:]]
    spec.add_pair(
        geomname1=one.name,
        geomname2=other.name,
        condim=condim,
        friction=np.repeat(friction, [2, 1, 2]),
        solref=first.solref,
        solimp=solimp,
    )
