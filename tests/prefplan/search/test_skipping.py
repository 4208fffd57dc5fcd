"""Plans that skip tasks, where several readings of what is meant are conceivable."""

from __future__ import annotations

from prefplan import Expression, Plan, Problem, Sum, Task, TransitionSystem, WeightedSum, pareto_front

LINE = TransitionSystem.from_transitions(
    [("s", "go", "t", 1), ("t", "on", "u", 9)], start="s", labels={"t": ["a"], "u": ["b"]}
)


def test_a_task_may_be_skipped_although_the_plan_satisfies_it() -> None:
    together = Expression("abs(early - late)")
    preference = Sum(((together, 1), (WeightedSum({"early": 1}, over="violation"), 1)))
    problem = Problem(LINE, [Task("early", "F a", skip=2), Task("late", "F b")], preference)
    (plan,) = pareto_front(problem)
    assert (plan.actions, plan.preference) == (("go", "on"), 2)
    assert (plan.task_costs, plan.violation_costs) == ({"early": 10, "late": 10}, {"early": 2, "late": 0})


def test_a_plan_is_empty_where_nothing_is_left_to_do() -> None:
    def cheapest(task: Task) -> Plan:
        return pareto_front(Problem(LINE, [task], WeightedSum({task.name: 1}, over="violation")))[0]

    for task, paid in ((Task("skipped", "F b", skip=4), 4), (Task("done", "F !b", skip=4), 0)):
        plan = cheapest(task)
        assert (plan.cost, plan.preference, plan.actions, plan.states) == (0, paid, (), ("s",))
