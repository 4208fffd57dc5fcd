"""The views that a video may have."""

import mujoco
import numpy as np

from sim.errors import RenderingError
from sim.geometry.mjcf import first_met, is_solid, opaque
from sim.rendering.framing import home_points, label_anchors, object_corners, of_fixtures, work_points
from sim.rendering.labels import place_labels
from sim.world.materials import WRIST
from sim.world.scene import Scene

CAMERAS = ("fixed", "orbit", WRIST, "top")
"""In front of the table; swinging around the front, once left and right in a video; on the hand; straight above."""

AZIMUTH_DEG = 156.0
"""Heading of `fixed`, degrees: from the right in front of a robot that looks along x."""

ELEVATION_DEG = -28.0
"""Pitch of `fixed` and `orbit`, degrees: down onto the table."""

HEADINGS_DEG = (0.0, 48.0, -46.0, 94.0, -86.0, 134.0, -112.0, 160.0, -138.0)
"""Offsets of the heading of `fixed` to try, degrees; the one with which fixtures hide least is used."""

SEEN_CORNERS = 4
"""Least number of visible corners of the box round an object that counts as seen."""

SWING_DEG = 70.0
"""Angle by which `orbit` swings to either side, degrees: beyond it, the arm hides its own work."""

MARGIN = 0.03
"""Share of the picture's width and height that stays free on every side."""


class Camera:
    """A view of a scene; `fixed`, `orbit` and `top` show all objects, all locations and the hand at work.

    A `mounted` camera is one of the MuJoCo model's own, such as `wrist`.
    """

    def __init__(self, scene: Scene, name: str, size: tuple[int, int], *, opening: float = 0.0) -> None:
        """Compute what has to fit into a picture of a size, (width, height) in pixels.

        The name is one of `camera_names`, or a text for `read_view`, else `RenderingError` is raised. In the first
        share `opening` of the video, the camera moves in from a view that includes the hand at home.
        """
        self.name = name
        self.mounted = name == WRIST or name in camera_names(scene)[len(CAMERAS) :]
        self.size = size
        self._scene, self._size = scene, np.array(size)
        self._chosen = None if self.mounted or name in CAMERAS else read_view(name)
        self._slope = float(np.tan(np.radians(scene.mujoco.vis.global_.fovy) / 2))
        self._points, self._home, self._opening = work_points(scene), home_points(scene), opening
        self._heading = self._best_heading()

    def view(self, share: float = 0.0) -> mujoco.MjvCamera:
        """Return MuJoCo's camera when a share, 0 .. 1, of the video has passed."""
        view = mujoco.MjvCamera()
        if self.mounted:
            view.type = mujoco.mjtCamera.mjCAMERA_FIXED
            view.fixedcamid = self._scene.mujoco.camera(self.name).id
            return view
        view.lookat = (self._points.min(axis=0) + self._points.max(axis=0)) / 2
        if self._chosen:
            view.azimuth, view.elevation, view.distance = self._chosen
            return view
        swing = SWING_DEG * np.sin(2 * np.pi * share) if self.name == "orbit" else 0.0
        view.azimuth, view.elevation = self._heading + swing, ELEVATION_DEG
        if self.name == "top":
            view.azimuth, view.elevation = float(np.degrees(self._scene.robot.yaw)) + 180.0, -90.0
        axes = axes_of(view)
        eye = self._eye(axes, self._points)
        if share < self._opening:
            # A point in view at both ends of a straight path is in view all along.
            wide = self._eye(axes, np.concatenate([self._points, self._home]))
            eye = wide + _eased(share / self._opening) * (eye - wide)
        view.distance = (axes @ (view.lookat - eye))[2]
        view.lookat = eye + view.distance * axes[2]
        return view

    def _eye(self, axes: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the (3,) nearest camera position, m, from which (N, 3) points are in the picture."""
        slopes = (1 - 2 * MARGIN) * self._slope * self._size / self._size[1]
        return np.asarray(_nearest_eye(points @ axes.T, slopes) @ axes)

    def _best_heading(self) -> float:
        """Return the azimuth of `fixed`, degrees."""
        usual, view = float(np.degrees(self._scene.robot.yaw)) + AZIMUTH_DEG, mujoco.MjvCamera()
        if not self._scene.model.fixtures:
            return usual
        model, corners = self._scene.mujoco, object_corners(self._scene)
        fixtures = mujoco.MjData(opaque(model, is_solid(model) & of_fixtures(self._scene)))
        mujoco.mj_kinematics(fixtures.model, fixtures)
        best, most = usual, 0
        for turn in HEADINGS_DEG:
            view.azimuth, view.elevation = usual + turn, ELEVATION_DEG
            eye = self._eye(axes_of(view), self._points)
            met = [first_met(fixtures.model, fixtures, eye, point - eye)[1] for point in corners.reshape(-1, 3)]
            seen = np.array([not 0 <= distance < 1 for distance in met]).reshape(corners.shape[:2])
            if (slots := int((seen.sum(axis=1) >= SEEN_CORNERS).sum())) > most:
                best, most = usual + turn, slots
        return best

    def shares(self) -> np.ndarray:
        """Return (V,) shares of the video whose views cover the camera's whole motion evenly."""
        return np.linspace(0.25, 0.75, 36) if self.name == "orbit" else np.zeros(1)

    def pixels(self, points: np.ndarray, share: float = 0.0) -> np.ndarray:
        """Return the (N, 2) pixels, from the left and the top, where (N, 3) points, m, are in the picture.

        The camera is not mounted; a point behind it is far outside.
        """
        view = self.view(share)
        right, up, ahead = (axes_of(view) @ (points - view.lookat).T) + [[0.0], [0.0], [view.distance]]
        scale = self._size[1] / (2 * self._slope)
        return self._size / 2 + scale * np.stack([right, -up], axis=1) / np.maximum(ahead, 1e-3)[:, None]


def camera_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of a scene's cameras: `CAMERAS`, then others in its MJCF."""
    model = scene.mujoco
    return tuple(dict.fromkeys([*CAMERAS, *(name for i in range(model.ncam) if (name := model.camera(i).name))]))


def read_view(text: str) -> tuple[float, float, float]:
    """Return azimuth and elevation, degrees, and distance, m, of a camera given as `az,el,dist`.

    Azimuth 180 looks towards the robot from in front of it, elevation -90 straight down. Raises `RenderingError` if the
    text is not of this form, or a number is out of range.
    """
    try:
        azimuth, elevation, distance = map(float, text.split(","))
    except ValueError:
        raise RenderingError(f"{text!r} is not `az,el,dist`, such as 156,-28,1.2") from None
    if not (abs(azimuth) <= 360 and abs(elevation) <= 90 and 0 < distance <= 10):
        raise RenderingError(f"{text!r}: azimuth within 360, elevation within 90 degrees, distance up to 10 m")
    return azimuth, elevation, distance


def label_offsets(scene: Scene, camera: Camera) -> dict[str, np.ndarray]:
    """Return the (2,) offsets in pixels from each anchor to its name that keep the names clear in all views."""
    shares, anchors, corners = camera.shares(), label_anchors(scene), object_corners(scene).reshape(-1, 3)
    points = np.stack([camera.pixels(np.array([*anchors.values()]), share) for share in shares], axis=1)
    boxes = np.stack([camera.pixels(corners, share).reshape(-1, 8, 2) for share in shares])
    obstacles = np.concatenate([boxes.min(axis=2), boxes.max(axis=2)], axis=2)
    return place_labels(dict(zip(anchors, points, strict=True)), obstacles, camera.size)


def axes_of(view: mujoco.MjvCamera) -> np.ndarray:
    """Return the unit vectors to the right, up and ahead of a view, (3, 3), in rows."""
    heading, pitch = np.radians([view.azimuth, view.elevation])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    ahead = np.array([np.cos(pitch) * np.cos(heading), np.cos(pitch) * np.sin(heading), np.sin(pitch)])
    return np.array([right, np.cross(right, ahead), ahead])


def _eased(share: float) -> float:
    """Return the share of a path after a share of the time, with zero speed at both ends."""
    return share * share * (3 - 2 * share)


def _nearest_eye(points: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the (3,) nearest camera position from which (N, 3) points, m, are in the picture.

    Axes point to the right, up and ahead; slopes are the tangents of half the horizontal and vertical field of view.
    Each of the four side planes of the view frustum is moved until it touches a point. The two planes of the tighter
    direction meet at the camera, the others behind it.
    """
    high = (points[:, :2] - slopes * points[:, 2:]).max(axis=0)
    low = (points[:, :2] + slopes * points[:, 2:]).min(axis=0)
    return np.array([*(high + low) / 2, ((low - high) / (2 * slopes)).min()])
