from scenario_texts import shipped
from skill_runs import assert_clean, assert_placed, perform_all

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
