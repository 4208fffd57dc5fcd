from __future__ import annotations

import pytest

import prefplan as pp
from prefplan.scenario.decode import loads
from prefplan.text.names import LONGEST_LABEL

SHELF = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
left = { at = [0.5, 0.1], label = "right" }
right = { at = [0.5, -0.1], label = "left" }
san = { at = [0.4, 0.3], label = "sanitizer [UV]" }
[model.objects]
left = { start = "left", label = "red cup" }
[[tasks]]
name = "phi1"
label = "wash"
formula = "F left_san"
skip = 20
[preference]
kind = "weighted-sum"
over = "violation"
weights = { phi1 = 1 }
"""


def test_people_are_shown_labels_and_all_else_keeps_names() -> None:
    labelled = loads(SHELF)
    plain = loads("\n".join(line for line in SHELF.splitlines() if not line.startswith("label")))
    front, other = (pp.pareto_front(one) for one in (labelled, plain))
    assert list(front) == list(other)
    assert front[-1].actions == ("transit left", "grasp left", "transport left san", "release left san")
    assert front[-1].task_costs == {"phi1": 10}
    shown = (
        "1. transit right, 2. grasp red cup, 3. transport red cup sanitizer [UV],\n4. release red cup sanitizer [UV]"
    )
    assert str(front[-1]).endswith(shown)
    assert "  wash satisfied at cost 10\n" in str(front[-1])
    assert "  wash is skipped, for 20" in str(front[0]) and "phi1" not in str(front)


@pytest.mark.parametrize("action", ["stay", "transport left", "transit nowhere", "N", "throw left san"])
def test_an_action_that_names_nothing_with_a_label_is_shown_as_it_is(action: str) -> None:
    assert loads(SHELF).problem().display.action(action) == action


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"wash"', "3", "tasks[0].label: must be a string, not 3"),
        ('"wash"', '""', "tasks[0].label: must be one line of 1 to 40 printable characters"),
        ('"red cup"', '"red\\ncup"', "model.objects.left.label: must be one line"),
        ('"red cup"', '"red\\u202ecup"', "model.objects.left.label: must be one line"),
        ('"red cup"', '" cup"', "model.objects.left.label: must be one line"),
        ('"red cup"', f'"{"a" * (LONGEST_LABEL + 1)}"', "model.objects.left.label: must be one line"),
        (', label = "left"', "", "model.locations.right.label: locations 'left' and 'right' would both be shown as"),
        ('label = "wash"', 'lable = "wash"', "tasks[0].lable: unknown key (did you mean 'label'?)"),
    ],
)
def test_a_bad_label_is_refused(old: str, new: str, message: str) -> None:
    assert old in SHELF
    with pytest.raises(pp.PrefplanError) as error:
        loads(SHELF.replace(old, new, 1)).problem()
    assert message in str(error.value)


def test_two_tasks_may_not_be_shown_alike() -> None:
    tasks = [pp.Task("a", "F left_san"), pp.Task("b", "F left_right", label="a")]
    with pytest.raises(pp.PrefplanError, match=r"tasks\[1\].label: tasks 'a' and 'b' would both be shown as 'a'"):
        pp.Problem(loads(SHELF).model, tasks)
