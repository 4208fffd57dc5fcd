"""Grippers: how a hand is commanded, how it holds an object, and the space that it needs."""

import math
from dataclasses import dataclass

import numpy as np

SUCTION_OPENING_M = 0.03
"""Commanded width at which the vacuum of a suction cup is off, m."""

SUCTION_SQUEEZE_M = 0.015
"""How far the commanded width is below the width of the held object (0) when the vacuum is on, m."""

GRAVITY_M_S2 = 9.81

CARRYING_ACCELERATION_M_S2 = 4.0
"""Sideways acceleration at which a suction cup must hold an object, m/s2. With the Panda's cup, a box 10 cm high of
1.2 kg (limit 3.5 m/s2) was torn off, and a cube of 6 cm and 1.4 kg (limit 4.4 m/s2) was carried."""

USUAL_LOAD_KG = 1.5
"""Mass above which objects are pressed harder in proportion, kg: with 15 N, 3 kg slip between the Panda's pads."""

PAD_CLEARANCE_M = 0.0075
"""Least distance from an object to either pad of the open hand where there is space, m."""

MIN_HELD_WIDTH_M = 0.005
"""Least commanded width of the hand that holds an object, m."""

MAX_LENGTH_M = 0.120
"""Greatest length of an object across the closing direction, m: a longer one turns between the fingers."""

MAX_LIFT_M = 0.022
"""Greatest distance of the pads' middle from an object's, m. At this distance, half of the pads hold a default cube,
2 mm over a bin's rim, and the object is near enough to the tool to count as held."""


@dataclass(frozen=True, eq=False)
class Linkage:
    """Table from widths to commands and joint positions, K rows: for fingers that do not slide by equal shares.

    Attributes:
        widths: (K,) between the pads, m, ascending.
        commands: (K,) of the actuator.
        positions: (K, k) of the joints, rad or m.
    """

    widths: np.ndarray
    commands: np.ndarray
    positions: np.ndarray


@dataclass(frozen=True, eq=False)
class Gripper:
    """Two fingers that close along the y axis of the tool frame.

    Attributes:
        actuator: drives the fingers; without a linkage, its command is the width between the pads, m.
        joints: joints of the fingers; without a linkage, each slides by an equal share of the width.
        pads: geoms of the left and the right pad, which hold an object.
        opening_m: greatest width between the pads.
        squeeze_m: how far the commanded width is below that of a held object of at most `USUAL_LOAD_KG`.
        firm_force_n: least contact force on each pad in a firm grip.
        finger_depth_m: depth of a finger, from its pad outwards along y, clearance included.
        finger_half_width_m: half width of a finger along x, clearance included.
        fingertip_m: how far the fingertips reach below the tool frame, clearance included.
        palm_height_m: height of the palm above the tool frame, clearance subtracted.
        palm_half_width_m: half width of the palm along x, clearance included.
        linkage: maps widths to commands and positions; None for fingers that slide.
    """

    actuator: str
    joints: tuple[str, ...]
    pads: tuple[str, ...]
    opening_m: float
    squeeze_m: float
    firm_force_n: float
    finger_depth_m: float
    finger_half_width_m: float
    fingertip_m: float
    palm_height_m: float
    palm_half_width_m: float
    linkage: Linkage | None = None

    @property
    def held_lengths(self) -> dict[str, tuple[float, float]]:
        """Least and greatest lengths it can grasp, m: `wide` along the closing direction, `long` across it, and `high`.

        In a grasp from above, the fingertips would touch the surface below a lower object, the palm a higher object.
        """
        return {
            "wide": (self.squeeze_m + MIN_HELD_WIDTH_M, self.opening_m - 2 * PAD_CLEARANCE_M),
            "high": (2 * self.fingertip_m, 2 * (self.palm_height_m + MAX_LIFT_M)),
            "long": (0.0, MAX_LENGTH_M),
        }

    def held_mass(self, height: float) -> float:
        """Return the greatest mass it can hold, kg, by the object's height, m; infinite: fingers press as needed."""
        return math.inf

    def command(self, width: float) -> float:
        """Return the actuator's command for a width between the pads, m."""
        return width if self.linkage is None else _between(self.linkage.widths, self.linkage.commands, width)

    def width(self, command: float) -> float:
        """Return the width between the pads that corresponds to an actuator command, m."""
        if self.linkage is None:
            return command
        order = np.argsort(self.linkage.commands)
        return _between(self.linkage.commands[order], self.linkage.widths[order], command)

    def pressing(self, width: float, mass: float) -> float:
        """Return the width to command, m, to hold an object of a width, m, and a mass, kg, firmly."""
        return max(0.0, width - self.squeeze_m * max(1.0, mass / USUAL_LOAD_KG))

    def positions(self, width: float) -> np.ndarray:
        """Return the (k,) positions of the fingers' joints at a width between the pads, m."""
        if self.linkage is None:
            return np.full(len(self.joints), width / max(1, len(self.joints)))
        columns = self.linkage.positions.T
        return np.array([np.interp(width, self.linkage.widths, column) for column in columns])

    def opened(self, positions: np.ndarray) -> float:
        """Return the width between the pads at (k,) positions of the fingers' joints, m."""
        if self.linkage is None:
            return float(np.sum(positions))
        leader = int(np.ptp(self.linkage.positions, axis=0).argmax())
        known = self.linkage.positions[:, leader]
        order = np.argsort(known)
        return float(np.interp(positions[leader], known[order], self.linkage.widths[order]))

    def holds(self, command: float) -> bool:
        """Return whether the gripper can hold an object at an actuator command, given that the pads press it."""
        return True


@dataclass(frozen=True, eq=False)
class SuctionGripper(Gripper):
    """A suction cup, its lip at the tool frame, which holds an object by a face of it.

    It is commanded in widths like fingers: a held object counts as 0 wide, and the vacuum is on while the commanded
    width is negative. The actuator is MuJoCo's adhesion; its command is 1 for vacuum, else 0.

    Attributes:
        joints: joint of the spring that yields when the cup is pressed on an object.
        pads: geom of the lip.
        opening_m: commanded width without vacuum.
        finger_depth_m: half width of the cup along y, clearance included.
        finger_half_width_m: half width of the cup along x, clearance included.
        press_m: how far the hand moves on after the lip has touched an object.
        force_n: suction force.
    """

    press_m: float = 0.003
    force_n: float = math.inf

    @property
    def held_lengths(self) -> dict[str, tuple[float, float]]:
        """See `Gripper.held_lengths`: at least as wide as its lip."""
        return {"wide": (2 * self.finger_half_width_m, math.inf)} | dict.fromkeys(("high", "long"), (0.0, math.inf))

    def held_mass(self, height: float) -> float:
        """See `Gripper.held_mass`: the suction beyond the weight keeps the object from tilting off the lip."""
        lever = CARRYING_ACCELERATION_M_S2 / GRAVITY_M_S2 * height / 2 / self.finger_half_width_m
        return self.force_n / GRAVITY_M_S2 / (1 + lever)

    def command(self, width: float) -> float:
        """See `Gripper.command`."""
        return float(width < 0)

    def width(self, command: float) -> float:
        """See `Gripper.width`."""
        return -self.squeeze_m if self.holds(command) else self.opening_m

    def pressing(self, width: float, mass: float) -> float:
        """See `Gripper.pressing`; the vacuum does not depend on the mass."""
        return width - self.squeeze_m

    def positions(self, width: float) -> np.ndarray:
        """See `Gripper.positions`."""
        return np.zeros(len(self.joints))

    def holds(self, command: float) -> bool:
        """See `Gripper.holds`."""
        return command > 0


def _between(known: np.ndarray, values: np.ndarray, at: float) -> float:
    """Return a linear interpolation between values at ascending points, and an extrapolation beyond them."""
    i = int(np.clip(np.searchsorted(known, at) - 1, 0, len(known) - 2))
    share = (at - known[i]) / (known[i + 1] - known[i])
    return float(values[i] + share * (values[i + 1] - values[i]))
