"""The outcome of a run, as text and as JSON."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from experiments.cli.output import plan_json
from experiments.runs.certificates import Proof, in_a_line
from prefplan import Ledger, Plan, Purchase, Scenario
from prefplan.exact_costs import Number
from prefplan.models.manipulation.action_costs import QUANTITIES, MeasuredCosts
from prefplan.text.layout import condense, number
from prefplan.text.names import DisplayNames
from sim import Certificate, Event, Fault, Run, Scene

NEWS = {
    "fault": "fault {fault}",
    "not injected": "fault {fault} did not happen: {reason}",
    "refused": "fault {fault} is not possible now: {reason}",
    "turned over": "{object} turned over: no single grasp sets it upright",
    "set aside": "{object} set aside: where it lay, no single grasp set it upright",
    "drawn free": "{object} dragged free: the fingers had no room beside it",
    "retry": "{reason}: tried again",
    "unaffected": "{reason}: what is left of the plan is not affected",
    "replan": "{reason}: planned again, cost {cost}, penalty {preference}: {plan}",
    "ended": "given up: {reason}",
}
"""The events to show, and their words."""


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run: JSON, log, captions, report and certificate are made from it.

    Attributes:
        scenario: the scenario of the plan.
        scene: the scene of the run.
        plan: the last plan that was followed.
        run: what was recorded.
        ledger: costs and satisfied tasks, from the observations after each action.
        setting: the run's seed, perturbation and faults, JSON-ready.
        faults: the faults, and the simulated time at which each happened, s; None if it did not.
        video: its file, or None.
        no_video: why there is none although one was requested, in one sentence.
        interrupted: whether the user ended the run early.
        proof: the run's log and its certificate, or None.
    """

    scenario: Scenario
    scene: Scene
    plan: Plan
    run: Run
    ledger: Ledger
    setting: dict[str, Any] = field(default_factory=dict)
    faults: tuple[tuple[Fault, float | None], ...] = ()
    video: Path | None = None
    no_video: str | None = None
    interrupted: bool = False
    proof: Proof | None = None

    @property
    def certificate(self) -> Certificate | None:
        """The certificate of the run's log, or None."""
        return self.proof.certificate if self.proof else None

    @property
    def relaxations(self) -> tuple[Purchase, ...]:
        """The relaxations of the plan that the executed actions use."""
        return tuple(bought for bought in self.plan.relaxations if bought.step <= len(self.run.steps))

    @property
    def seed(self) -> int | None:
        """The seed of the random numbers, or None."""
        return self.setting.get("seed")

    @property
    def measured(self) -> dict[str, Any] | None:
        """The quantity that is the cost, as predicted and as executed; None if costs were given as numbers."""
        costs = self.scene.model.costs
        if not isinstance(costs, MeasuredCosts):
            return None
        executed = float(sum(getattr(step.effort, costs.quantity) for step in self.run.steps))
        return {"quantity": costs.quantity, "predicted": self.ledger.final.cost, "executed": round(executed, 3)}

    @property
    def completed(self) -> bool:
        """Whether the plan was carried out and the log does not refute this."""
        return self.reason is None

    @property
    def reason(self) -> str | None:
        """Why the run was not completed, in one sentence; None if it was."""
        if self.run.completed and self.certificate is not None and self.certificate.refuted:
            first = self.certificate.refuted[0]
            return f"the log refutes it: {first.name}: {first.words}"
        return self.run.reason

    @property
    def executed(self) -> tuple[str, ...]:
        """The actions that were carried out."""
        return tuple(step.action for step in self.run.steps)

    @property
    def task_costs(self) -> dict[str, Number]:
        """Each task's cost, by name."""
        return self.ledger.final.task_costs


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    """Return an outcome as the documented JSON object."""
    run = outcome.run
    result = {
        "completed": outcome.completed,
        "plan": plan_json(outcome.plan),
        "executed": list(outcome.executed),
        "task_costs": outcome.task_costs,
        "replans": run.replans,
        "sim_seconds": round(run.sim_seconds, 3),
        "max_placement_error_mm": round(run.placement_error * 1000, 3),
        "video": None if outcome.video is None else str(outcome.video),
        "log": None if outcome.proof is None else str(outcome.proof.path),
        "certified": None if outcome.certificate is None else outcome.certificate.confirmed,
        "events": [{"time": round(event.time, 3), "kind": event.kind} | event.detail for event in run.events],
    }
    if outcome.measured:
        result["measured"] = outcome.measured
    if outcome.faults:
        result["seed"] = outcome.seed
        result["faults"] = [
            {"fault": str(fault), "time": None if time is None else round(time, 3)} for fault, time in outcome.faults
        ]
    if outcome.reason is not None:
        result["reason"] = outcome.reason
    if run.violated:
        result["violated"] = list(run.violated)
    if outcome.interrupted:
        result["complete"] = False
    return result


def show_outcome(console: Console, outcome: Outcome) -> None:
    """Print an outcome."""
    plan, run, name = outcome.plan, outcome.run, outcome.scenario.name
    done = f"{len(outcome.executed)} of {len(plan.actions)} actions"
    if outcome.completed:
        console.print(f"{name}: carried out, {done}, cost {number(outcome.ledger.final.cost)}", style="bold")
    else:
        verdict = "wrongly called completed" if run.completed else "stopped"
        console.print(f"{name}: {verdict} after {done}", style="bold")
        console.print(f"  {outcome.reason}")
    for line in news_of((event for event in run.events if event.kind != "ended"), plan.display):
        console.print(f"  {line}")
    if outcome.faults:
        console.print(f"  seed of the faults {outcome.seed or 0}")
    for task, cost in outcome.task_costs.items():
        shown = plan.display.task(task)
        if task in outcome.ledger.final.satisfied:
            console.print(f"  {shown} satisfied at cost {number(cost)}")
        else:
            lost = ", and no longer possible" if task in run.violated else ""
            console.print(f"  {shown} not satisfied{lost}")
    for bought in outcome.relaxations:
        console.print(f"  {bought.words(plan.display.task(bought.task))}")
    console.print(f"  penalty of the plan {number(plan.preference)}")
    if outcome.measured:
        quantity, predicted, executed = outcome.measured.values()
        unit = QUANTITIES[quantity]
        console.print(f"  {quantity} {executed:.1f} {unit}, predicted {number(predicted)} {unit}")
    if any(event.kind == "placed" for event in run.events):
        console.print(f"  placed to within {run.placement_error * 1000:.1f} mm")
    factor = run.sim_seconds / run.wall_seconds
    console.print(f"  {run.sim_seconds:.1f} s simulated, {factor:.0f} x real time")
    if outcome.video:
        console.print(f"  video: {outcome.video}")
    if outcome.proof:
        console.print(f"  log: {outcome.proof.path}")
    if outcome.certificate:
        console.print(f"  {in_a_line(outcome.certificate)}")


def news_of(events: Iterable[Event], display: DisplayNames) -> list[str]:
    """Return a line for each event of a kind in `NEWS`."""
    return [f"{event.time:6.1f} s  {_in_words(event, display)}" for event in events if event.kind in NEWS]


def _in_words(event: Event, display: DisplayNames) -> str:
    detail = dict(event.detail)
    if "object" in detail:
        detail["object"] = display.obj(detail["object"])
    if event.kind == "replan":
        detail |= {key: number(detail[key]) for key in ("cost", "preference")}
        detail["plan"] = condense([*map(display.action, detail["plan"])]) or "nothing is left to do"
        for name in detail.get("violated", ()):
            detail["plan"] += f"; {display.task(name)} is violated as it is written"
        for name, spot in detail.get("spots", {}).items():  # temporary locations, each in a line of its own
            where = "at x {:.3f}, y {:.3f} m".format(*spot["at"])
            detail["plan"] += f"\n    {name}: where {display.obj(spot['object'])} lies, off every location, {where}"
    return NEWS[event.kind].format(**detail)
