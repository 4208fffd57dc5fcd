"""`prefplan list`: the scenarios that ship."""

from typing import Any

import prefplan as pp
from experiments import scenarios
from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console, table
from experiments.cli.status import DONE
from prefplan.scenario.files import contents, text_of


@command
@options.as_json
def list(as_json: bool) -> int:
    """List the scenarios that ship, and what each is about.

    Examples:
      prefplan list
      prefplan list --json

    Other commands accept these names as SCENARIO. `prefplan init` starts a scenario of your own.
    """
    found = [_entry(name) for name in scenarios.names()]
    if not as_json:
        rows = [(one["name"], f"{one['summary']} ({one['kind']}, {one['tasks']} tasks)") for one in found]
        shown = table("", ("scenario", "what it is about"), rows, bold=[0])
        shown.show_lines, shown.columns[0].no_wrap = True, True  # on a terminal most summaries wrap; names are copied
        Console().print(shown)
        return DONE
    from prefplan.preferences.objective import Measure

    for one in found:
        scenario = pp.load(one["name"], measured=False)
        names = [task.name for task in scenario.tasks]
        one["contract"] = Measure(scenario.preference.terms(names), len(names)).contract
    output.print_json({"scenarios": found})
    return DONE


def _entry(name: str) -> dict[str, Any]:
    """Return the entry of a scenario, from the text of its file alone: the planner takes half a second to load."""
    path = scenarios.FOLDER / f"{name}.toml"
    text = text_of(path)
    values = contents(text, path)
    summary = scenarios.first_sentence(text)
    return {"name": name, "kind": values["model"]["kind"], "tasks": len(values["tasks"]), "summary": summary}
