"""The page about random scenes: the check's answers beside what became of the scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from operator import itemgetter
from statistics import median

from experiments.sweep.summary import share, wilson
from experiments.sweep.workers import Record
from judge.random_scenes.trial import COMPLETED, ERROR, FAILED, OUTCOMES, REFUTED

MAX_ACTION_S = 10.0
"""An action should take no longer in simulated time, s."""

ANSWERS = {True: "yes", False: "no: carried out without the test that refused", None: "no answer in time"}
"""The answers of `prefplan check`, in words."""

TIMES = ("sim_seconds", "check_cpu_seconds", "run_cpu_seconds")

Records = Sequence[Record]


def markdown(records: Records, *, scenes: int, seed: int, about: str) -> str:
    """Return the results as Markdown: tables and lists of the page `experiments/results/random_scenes.md`.

    Args:
        records: of the finished scenes.
        scenes: number of scenes that were asked for.
        seed: of the scenes.
        about: versions, in words.
    """
    call = f"`PYTHONPATH=tests python -m judge.random_scenes --scenes {scenes} --seed {seed}`"
    parts = [
        f"{call}, {about}: {len(records)} of {scenes} scenes finished. Brackets: 95 % interval (Wilson).",
        _answers(records),
        _figures(records),
        _refusals(records),
        _list("Allowed, but not completed", [r for r in records if r["allowed"] and r["outcome"] != COMPLETED]),
        _list("Refused, but completed", [r for r in records if _is_false_no(r)]),
        _list("Program errors", [r for r in records if r["outcome"] == ERROR]),
    ]
    return "\n\n".join(part for part in parts if part)


def _table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table whose columns after the first are numbers."""
    ruled = [heads, ["---", *["---:"] * (len(heads) - 1)], *rows]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in ruled)


def _answers(records: Records) -> str:
    """Return the table of the check's answers and the outcomes."""
    rows = []
    for answer, words in ANSWERS.items():
        found = Counter(record["outcome"] for record in records if record["allowed"] is answer)
        rows.append([words, found.total(), *(found[outcome] for outcome in OUTCOMES)])
    return _table(["`prefplan check`", "scenes", *OUTCOMES], rows)


def _figures(records: Records) -> str:
    """Return the table of what is asked of the check and of the runs."""
    allowed = [record for record in records if record["allowed"]]
    # Only a run that came to an end shows whether the refusal was right.
    tried = [r for r in records if r["allowed"] is False and r["outcome"] in (COMPLETED, FAILED, REFUTED)]
    false_no = sum(map(_is_false_no, tried))
    interval = wilson(false_no, len(tried))
    between = " [{:.1%}, {:.1%}]".format(*interval) if interval else ""
    outcomes = Counter(record["outcome"] for record in allowed)
    ran = [record for record in records if "sim_seconds" in record]
    slow = sum(record["longest_action_seconds"] > MAX_ACTION_S for record in ran)
    rows = {
        "false yes: allowed, and the run hits something or is refuted (asked: 0)": str(outcomes[REFUTED]),
        "of these, wrongly called completed": str(sum(record.get("wrongly_completed", False) for record in allowed)),
        "allowed, and failed honestly": share(outcomes[FAILED], len(allowed)),
        "false no: refused, and completed without that test (asked: under 5 %)": share(false_no, len(tried)) + between,
        f"runs with an action over {MAX_ACTION_S:g} s (asked: 0)": str(slow),
    }
    if ran:
        longest = max(ran, key=itemgetter("longest_action_seconds"))
        times = {key: f"median {median(map(itemgetter(key), ran)):.0f} s" for key in TIMES}
        rows |= {
            "longest action": f"{longest['longest_action_seconds']:.1f} s: `{longest['longest_action']}` of scene "
            f"{longest['scene']}",
            "simulated time of a run": times["sim_seconds"],
            "processor time of finding the answer of the check, and of a plan and its run": (
                f"{times['check_cpu_seconds']} and {times['run_cpu_seconds']}"
            ),
        }
    return _table(["", ""], rows.items())


def _refusals(records: Records) -> str:
    """Return how often the check gave each reason, and in how many of these scenes the run was completed."""
    found = Counter(reason for record in records for reason in record["refusals"])
    false_no = Counter(reason for record in records if _is_false_no(record) for reason in record["refusals"])
    rows = [(reason, count, false_no[reason]) for reason, count in found.most_common()]
    return _table(["reason of a refusal; a scene may have several", "scenes", "false no"], rows) if rows else ""


def _list(title: str, records: Records) -> str:
    """Return a line for each of the records, each with its file and the reason for its outcome."""
    lines = [f"- scene {r['scene']}: {r['outcome']}{_why(r)}" for r in records]
    return "\n".join([f"{title}:", "", *lines]) if lines else ""


def _is_false_no(record: Record) -> bool:
    return record["allowed"] is False and record["outcome"] == COMPLETED


def _why(record: Record) -> str:
    reasons = [*record.get("refuted", ()), *record.get("findings", ()), *record["refusals"]] or [record.get("reason")]
    return "".join(f"; {reason}" for reason in reasons if reason)
