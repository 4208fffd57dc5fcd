import numpy as np
import pytest
from scenario_texts import shipped
from skill_runs import assert_clean, assert_placed, perform_all

from sim.errors import BlockedError
from sim.skills import grasp
from sim.skills.catalogue import perform
from sim.world.scene import build_scene


def test_the_hand_takes_what_stands_under_a_board_from_the_front_and_puts_it_down_there() -> None:
    scene = build_scene(shipped("shelf").model, meshes=False)
    cell = perform_all(scene, "transit pile", seed=None)
    tool, board = cell.arm.tool(cell.angles), scene.slots["high"][0].position[2]
    assert tool.position[2] < board and tool.rotation[0, 2] > 0.2  # tilted towards the shelf, and below the board
    for action in ("grasp jam", "transport jam aside", "release jam aside"):
        perform(cell, action)
    assert_clean(cell)
    assert_placed(cell, "jam", "aside")


def test_where_the_way_out_of_a_grasp_is_blocked_another_one_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = perform_all(build_scene(shipped("shelf").model, meshes=False), "transit pile", seed=None)
    lifts, raise_hand = [], grasp._raise

    def blocked_at_first(*arguments: object) -> None:
        lifts.append(cell.arm.tool(cell.reference).rotation[:, 2])
        if len(lifts) == 1:
            raise BlockedError.on_the_way({"fixture board"})
        raise_hand(*arguments)

    monkeypatch.setattr(grasp, "_raise", blocked_at_first)
    perform(cell, "grasp jam")
    assert cell.held() == "jam" and len(lifts) == 2
    assert lifts[0] @ lifts[1] < np.cos(np.radians(14))
