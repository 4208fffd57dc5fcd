"""The page about random scenes: the check's answers beside what became of the scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from statistics import median

from experiments.random_scenes.drawing import MASSES_KG, PITCHES_M
from experiments.random_scenes.trial import (
    COMPLETED,
    ERROR,
    FAILED,
    OUTCOMES,
    REFUTED,
    USUAL,
)
from experiments.sweep.summary import share, wilson
from experiments.sweep.workers import Record

MAX_ACTION_S = 10.0
"""An action should take no longer in simulated time, s."""

ANSWERS = {True: "yes", False: "no: carried out without the test that refused", None: "no answer in time"}
"""The answers of `prefplan check`, in words."""

Records = Sequence[Record]


def markdown(records: Records, *, scenes: int, seed: int, about: str) -> str:
    """Return the results as a page.

    Args:
        records: of the finished scenes, in any order.
        scenes: number of scenes that were asked for.
        seed: of the scenes.
        about: versions, in words.
    """
    records = sorted(records, key=lambda record: int(record["scene"]))
    return "\n".join(
        [
            "# Random scenes: what the check says, and what becomes of them",
            "",
            f"`python -m experiments.random_scenes --scenes {scenes} --seed {seed}`, {about}: {len(records)} of "
            f"{scenes} scenes finished. Each has 4 to 14 cubes, boxes and cylinders of {1000 * MASSES_KG[0]:.0f} g to "
            f"{MASSES_KG[1]:g} kg, locations from {100 * PITCHES_M[0]:.0f} cm apart "
            "(for 14 objects at most 16: the states of more cannot be numbered), up to three walls up to 50 cm "
            "high, a shelf in every third scene, stacks, two or three tasks, and start poses perturbed by "
            f"{USUAL} (mm and degrees). The cheapest plan of each scene is carried out, also where `prefplan check` "
            "refuses it: then without the test that refused it. A run is refuted if its log shows otherwise than it "
            "says, or that it hit something; one that says itself that it exceeded a limit has failed honestly. "
            "Brackets: 95 % interval (Wilson).",
            "",
            *_cross_table(records),
            "",
            *_figures(records),
            *_refusals(records),
            *_list("Allowed, but not completed", [r for r in records if r["allowed"] and r["outcome"] != COMPLETED]),
            *_list("Refused, but completed", [r for r in records if _is_false_no(r)]),
            *_list("Program errors", [r for r in records if r["outcome"] == ERROR]),
        ]
    )


def _cross_table(records: Records) -> list[str]:
    """Return the table of the check's answers and the outcomes."""
    rows = []
    for answer, words in ANSWERS.items():
        outcomes = Counter(record["outcome"] for record in records if record["allowed"] is answer)
        counts = (outcomes.total(), *(outcomes[outcome] for outcome in OUTCOMES))
        rows.append(f"| {words} | {' | '.join(map(str, counts))} |")
    heading = f"| `prefplan check` | scenes | {' | '.join(OUTCOMES)} |"
    return [heading, "| --- |" + " ---: |" * (1 + len(OUTCOMES)), *rows]


def _figures(records: Records) -> list[str]:
    """Return the table of what is asked of the check and of the runs."""
    allowed = [record for record in records if record["allowed"]]
    # Only a run that came to an end shows whether the refusal was right.
    tried = [r for r in records if r["allowed"] is False and r["outcome"] in (COMPLETED, FAILED, REFUTED)]
    false_no = sum(map(_is_false_no, tried))
    interval = wilson(false_no, len(tried))
    ran = [record for record in records if "sim_seconds" in record]
    rows = {
        "false yes: allowed, and the run hits something or is refuted (asked: 0)": str(
            sum(record["outcome"] == REFUTED for record in allowed)
        ),
        "of these, wrongly called completed": str(sum(record.get("wrongly_completed", False) for record in allowed)),
        "allowed, and failed honestly": share(sum(r["outcome"] == FAILED for r in allowed), len(allowed)),
        "false no: refused, and completed without that test (asked: under 5 %)": (
            share(false_no, len(tried)) + (f" [{interval[0]:.1%}, {interval[1]:.1%}]" if interval else "")
        ),
        f"runs with an action over {MAX_ACTION_S:g} s (asked: 0)": str(
            sum(record["longest_action_seconds"] > MAX_ACTION_S for record in ran)
        ),
    }
    if ran:
        longest = max(ran, key=lambda record: float(record["longest_action_seconds"]))
        deepest = max(ran, key=lambda record: float(record["penetration_mm"]))
        rows |= {
            "longest action": f"{longest['longest_action_seconds']:.1f} s: `{longest['longest_action']}` of scene "
            f"{longest['scene']}",
            "greatest penetration of an object": f"{deepest['penetration_mm']:.1f} mm, in scene {deepest['scene']}",
            "simulated time of a run": f"median {median(record['sim_seconds'] for record in ran):.0f} s",
            "processor time of finding the answer of the check, and of a plan and its run": " and ".join(
                f"median {median(record[key] for record in ran):.0f} s"
                for key in ("check_cpu_seconds", "run_cpu_seconds")
            ),
        }
    return ["| | |", "| --- | --- |", *(f"| {name} | {value} |" for name, value in rows.items())]


def _is_false_no(record: Record) -> bool:
    return record["allowed"] is False and record["outcome"] == COMPLETED


def _refusals(records: Records) -> list[str]:
    """Return how often the check gave each reason, and in how many of these scenes the run was completed."""
    found: dict[str, list[Record]] = {}
    for record in records:
        for reason in record["refusals"]:
            found.setdefault(reason, []).append(record)
    rows = sorted(found.items(), key=lambda entry: -len(entry[1]))
    table = (f"| {why} | {len(given)} | {sum(map(_is_false_no, given))} |" for why, given in rows)
    heading = ["", "| reason of a refusal; a scene may have several | scenes | false no |", "| --- | ---: | ---: |"]
    return [*heading, *table] if rows else []


def _list(title: str, records: Records) -> list[str]:
    """Return a line for each of the records, each with its file and the reason for its outcome."""
    lines = [f"- scene {r['scene']}: {r['outcome']}{_why(r)}" for r in records]
    return ["", f"{title}:", "", *lines] if lines else []


def _why(record: Record) -> str:
    reasons = [*record.get("refuted", ()), *record.get("findings", ()), *record["refusals"]] or [record.get("reason")]
    return "".join(f"; {reason}" for reason in reasons if reason)
