"""Statistics of a sweep: success rate with its confidence interval, measures, and classes of failures."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from rich.console import Console

from experiments.cli.console import table
from experiments.sweep.workers import Record

SHOWN = 5
"""Greatest number of rollouts that a summary names for one class of failures."""


def wilson(count: int, total: int) -> list[float] | None:
    """Return Wilson's score interval of a share, [low, high] at 95 %; None if the total is 0."""
    if not total:
        return None
    from scipy.stats import binomtest  # takes a second to load

    interval = binomtest(count, total).proportion_ci(0.95, "wilson")
    return [round(float(end), 6) for end in interval]


def summarise(header: Mapping[str, Any], records: Sequence[Record], *, rollouts: int) -> dict[str, Any]:
    """Return the statistics of a sweep as the documented JSON object; `rollouts` is the number requested."""
    done, completed = len(records), sum(record["completed"] for record in records)
    ran = [record for record in records if "sim_seconds" in record]
    cpu, simulated = sum(record["cpu_seconds"] for record in ran), sum(record["sim_seconds"] for record in ran)
    return {
        **header,
        "rollouts": rollouts,
        "done": done,
        "complete": done == rollouts,
        "completed": completed,
        "success_rate": round(completed / done, 6) if done else None,
        "success_interval": wilson(completed, done),
        "certificates": _certificates(records),
        "sim_seconds": _spread([record["sim_seconds"] for record in ran]),
        "placement_error_mm": _spread([record["placement_error_mm"] for record in ran]),
        "greatest_speed_share": max((record["speed_share"] for record in ran), default=None),
        "greatest_torque_share": max((record["torque_share"] for record in ran), default=None),
        "real_time_factor": round(simulated / cpu, 2) if cpu else None,
        "replans": {"total": sum(r["replans"] for r in ran), "max": max((r["replans"] for r in ran), default=0)},
        "happened": _happened(ran),
        "failures": _failures(records),
    }


def _happened(records: Sequence[Record]) -> dict[str, dict[str, int]]:
    """Return for each kind of fault the number of rollouts in which it happened, and how many were completed."""
    found: dict[str, dict[str, int]] = {}
    for record in records:
        for kind in {re.split("[:@]", fault)[0] for fault in record["happened"]}:
            row = found.setdefault(kind, {"rollouts": 0, "completed": 0})
            row["rollouts"] += 1
            row["completed"] += record["completed"]
    return dict(sorted(found.items()))


def _certificates(records: Sequence[Record]) -> dict[str, Any]:
    """Return the numbers of rollouts by certificate, and the rollouts that are refuted or have findings."""
    checked = [record for record in records if record["agrees"] is not None]
    refuted = [record for record in checked if not record["certified"]]
    return {
        "checked": len(checked),
        "proved": sum(record["proved"] for record in checked),
        "agree": sum(record["agrees"] for record in checked),
        "confirmed": len(checked) - len(refuted),
        "wrongly_completed": sum(record["wrongly_completed"] for record in records),
        "refuted": [{key: record[key] for key in ("rollout", "seed", "refuted", "replay")} for record in refuted],
        "findings": [
            {key: record[key] for key in ("rollout", "seed", "findings", "replay")}
            for record in checked
            if record.get("findings")  # records of earlier versions have none
        ],
    }


def _spread(values: list[float]) -> dict[str, float | None]:
    return {"median": round(median(values), 3), "max": max(values)} if values else {"median": None, "max": None}


def _failures(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Return the classes of failures, the most frequent first, each with its first `SHOWN` rollouts."""
    found = defaultdict[str, list[Record]](list)
    for record in records:
        if not record["completed"]:
            found[record["class"]].append(record)
    told = ("rollout", "seed", "reason", "replay")
    return [
        {
            "class": name,
            "count": len(failed),
            "interval": wilson(len(failed), len(records)),
            "rollouts": [{key: record[key] for key in told} for record in failed[:SHOWN]],
        }
        for name, failed in sorted(found.items(), key=lambda entry: -len(entry[1]))
    ]


def show_summary(console: Console, summary: Mapping[str, Any]) -> None:
    """Print the statistics as a table."""
    certificates, replans = summary["certificates"], summary["replans"]
    rows = [("perturbed by", summary["perturb"]), ("completed", share(summary["completed"], summary["done"]))]
    if summary["success_interval"]:
        rows.append(("95 % interval (Wilson)", "{:.1%} to {:.1%}".format(*summary["success_interval"])))
    rows.append(("certificates agree", share(certificates["agree"], certificates["checked"])))
    rows.append(("all checks hold", share(certificates["confirmed"], certificates["checked"])))
    if certificates["wrongly_completed"]:
        rows.append(("wrongly called completed", share(certificates["wrongly_completed"], summary["done"])))
    for name, key, unit in (("simulated", "sim_seconds", "s"), ("placed to within", "placement_error_mm", "mm")):
        spread = summary[key]
        if spread["max"] is not None:
            rows.append((name, f"median {spread['median']:.1f} {unit}, at most {spread['max']:.1f} {unit}"))
    if replans["total"]:
        rows.append(("planned again", f"{replans['total']} times, at most {replans['max']} a run"))
    rows += [
        (f"completed with {kind}", share(row["completed"], row["rollouts"]))
        for kind, row in summary["happened"].items()
    ]
    if summary["real_time_factor"]:
        rows.append(("speed", f"{summary['real_time_factor']:.1f} x real time a core"))
    done = f"{summary['done']} of {summary['rollouts']} rollouts"
    found = table(f"{summary['scenario']}, plan {summary['plan']}: {done}", ("", ""), rows)
    found.show_header = False
    console.print(found)
    for kind in summary["failures"]:
        console.print(f"\n{kind['count']} x {kind['class']}")
        for rollout in kind["rollouts"]:
            console.print(f"  {rollout['replay']}")
    for verdict in ("refuted", "findings"):
        for rollout in certificates[verdict][:SHOWN]:
            console.print(f"\n{verdict}: {'; '.join(rollout[verdict])}\n  {rollout['replay']}")


def share(count: int, total: int) -> str:
    """Return a share as text."""
    return f"{count} of {total} ({count / total:.1%})" if total else "none yet"
