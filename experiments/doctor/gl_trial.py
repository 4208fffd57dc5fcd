"""Render one picture with the OpenGL backend that MUJOCO_GL names: `python -m experiments.doctor.gl_trial`.

A process of its own, as a faulty driver may end it. It prints who rendered, or fails as the libraries do.
"""

from __future__ import annotations

import sys

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="box" size="0.5 0.5 0.5" rgba="1 0 0 1"/>
    <camera name="above" pos="0 0 3"/>
  </worldbody>
</mujoco>
"""
"""A red box on black, from above."""


def render() -> str:
    """Return the name of the renderer that drew the box.

    Raises:
        RuntimeError: the picture does not show it.
    """
    import mujoco
    from OpenGL import GL

    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 48, 64) as renderer:
        renderer.update_scene(data, "above")
        red, green, _ = renderer.render()[24, 32].tolist()
        if red < 40 or green > red / 2:
            raise RuntimeError("the picture does not show what was drawn")
        return bytes(GL.glGetString(GL.GL_RENDERER)).decode()


if __name__ == "__main__":
    print(render())
    # Mesa may complain as the process ends, when all is done.
    sys.stdout.flush()
