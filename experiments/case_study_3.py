"""Case Study 3 of the paper: a Panda sanitizes and bins two blocks of an arch, once cheaply and once as preferred.

Prints the Pareto front, carries out the plans at both its ends in simulation, films them and says what came of it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from experiments import output, scenarios
from experiments.carry_out import Tell, carry_out, scene_of
from experiments.console import Console
from experiments.files import write_json
from experiments.outcome import Outcome, outcome_json, show_outcome
from experiments.progress import Bars
from experiments.start import INTERRUPTED
from prefplan import Plan, Scenario, pareto_front
from sim.scene import Scene

SCENARIO = "case_study_3"

OUT = Path("out", SCENARIO)
"""Where the videos go."""


def main() -> int:
    """Plan, carry both plans out, and return the exit status."""
    console = Console(highlight=False)
    scenario = scenarios.find(SCENARIO)
    console.print("Planning", style="dim")
    front = pareto_front(scenario.problem())
    output.show_front(console, scenario, front)
    scene = scene_of(scenario)
    OUT.mkdir(parents=True, exist_ok=True)
    outcomes = []
    for name, plan in {"cost": front[0], "preference": front[-1]}.items():
        console.print(f"\nCarrying out and filming the {name}-optimal plan (cost {output.number(plan.cost)})")
        with Bars() as bars:
            outcomes.append(perform(scenario, scene, plan, name, tell=bars))
        show_outcome(console, scenario, outcomes[-1])
        if outcomes[-1].interrupted:
            return INTERRUPTED
    console.print("\nVideos")
    for outcome in outcomes:
        console.print(f"  {outcome.video or outcome.no_video}")
    return 0 if all(outcome.rollout.completed for outcome in outcomes) else 4


def perform(scenario: Scenario, scene: Scene, plan: Plan, name: str, *, tell: Tell) -> Outcome:
    """Carry a plan out; leave a video and a JSON record of what came of it in `OUT`."""
    outcome = carry_out(scenario, scene, plan, film=OUT / f"{name}.mp4", tell=tell)
    write_json(OUT / f"{name}.json", outcome_json(outcome))
    return outcome


if __name__ == "__main__":
    sys.exit(main())
