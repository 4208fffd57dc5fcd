"""How an execution stands, as HTML for the panel."""

from __future__ import annotations

from html import escape

from experiments.cli.output import number
from experiments.viewer.standing import Progress, Standing
from prefplan.exact_costs import Number

STYLE = """<style>
.standing { font-size: 0.85em; line-height: 1.45; padding: 0 0.75em 0.75em }
.standing table { border-collapse: collapse; width: 100%; margin: 0.5em 0 }
.standing td, .standing th { text-align: left; padding: 0.1em 0.4em; vertical-align: top; font-weight: inherit }
.standing td.number, .standing th.number { text-align: right }
.standing .muted { opacity: 0.6 }
.standing .satisfied { color: #2b8a3e }
.standing ol { margin: 0.3em 0; padding-left: 2.2em }
.standing li.current { font-weight: bold; background: #ffe8a3; color: #222 }
.standing .news { color: #c2410c }
</style>"""


def standing_html(standing: Standing, time: float, *, state: str) -> str:
    """Return how an execution stands as HTML.

    Args:
        standing: how it stands.
        time: simulated time, s.
        state: whether it goes on, is paused or has ended, and why.
    """
    plan, total = standing.plan, len(standing.plan.actions)
    now = f"{min(standing.done, total)} of {total} actions done, {time:.1f} s"
    parts = [
        STYLE,
        f'<div class="standing"><div><b class="count">{now}</b>, <span class="state">{escape(state)}</span></div>',
        "<table><tr class='muted'><th></th><th class='number'>so far</th><th class='number'>plan</th></tr>",
        _row("cost", standing.cost, plan.cost),
        _row("preference &mu;", standing.preference, plan.preference),
        "</table>",
        "<table><tr class='muted'><th>task</th><th>formula</th><th class='number'>satisfied at cost</th></tr>",
        *map(_task, standing.tasks),
        "</table>",
        *(f'<div class="news">{escape(line)}</div>' for line in standing.news),
        "<ol>",
        *(_action(k, action, standing) for k, action in enumerate(plan.actions)),
        "</ol></div>",
    ]
    return "\n".join(parts)


def _row(name: str, now: Number, whole: Number) -> str:
    return f"<tr><td>{name}</td><td class='number'>{number(now)}</td><td class='number'>{number(whole)}</td></tr>"


def _task(task: Progress) -> str:
    found = "open" if task.cost is None else number(task.cost)
    look = "muted" if task.cost is None else "satisfied"
    name, formula = escape(task.name), escape(task.formula)
    return f"<tr class='{look}'><td>{name}</td><td>{formula}</td><td class='number'>{found}</td></tr>"


def _action(k: int, action: str, standing: Standing) -> str:
    if k < standing.done:
        return f'<li class="muted">{escape(action)}</li>'
    if k == standing.done and standing.ended is None:
        return f'<li class="current">{escape(action)}</li>'
    return f"<li>{escape(action)}</li>"
