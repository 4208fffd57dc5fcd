"""Tasks in words: titles, and formulas for readers who do not know temporal logic."""

from collections import Counter
from collections.abc import Mapping

from prefplan import Formula, ManipulationModel, Scenario, Task
from prefplan.logic.formula import FALSE, TRUE, And, BoundedRelease, Literal, Or, Truth, Until
from prefplan.models.manipulation.symbolic import at, holding, marked
from prefplan.scenario.decode import Model


def titles(scenario: Scenario) -> dict[str, str]:
    """Return the title of each task and rule.

    A task's title is its label. Without one, it is its name, followed by its object if it is about a single object and
    no other task is about that.
    """
    subjects = {task.name: _subject(task, scenario.model) for task in scenario.tasks}
    count = Counter(subjects.values())
    titled = {
        name: f"{name} ({_shown(subject, scenario.model)})"
        for name, subject in subjects.items()
        if subject not in (None, name) and count[subject] == 1
    }
    return {task.name: task.label or titled.get(task.name, task.name) for task in scenario.tasks} | {
        rule.name: f"the rule {rule.name}" for rule in scenario.rules
    }


def _subject(task: Task, model: Model) -> str | None:
    """Return the object that a task is about; None if there is none, or more than one."""
    if not isinstance(model, ManipulationModel):
        return None
    goals = _goals(task.tree)
    found = [obj.name for obj in model.objects if goals & {name for name, _ in model.propositions_of(obj.name)}]
    return found[0] if len(found) == 1 else None


def _shown(obj: str | None, model: Model) -> str:
    """Return what is shown for an object."""
    return model.display.obj(obj) if obj and isinstance(model, ManipulationModel) else ""


def _goals(formula: Formula) -> set[str]:
    """Return the propositions that have to become true."""
    match formula:
        case Until(_, right) | BoundedRelease(_, right):
            return _goals(right)
        case And(operands) | Or(operands):
            return set().union(*map(_goals, operands))
        case Literal(name, True):
            return {name}
    return set()


def goal_words(task: Task, model: Model) -> str:
    """Return a task's goal in few words, e.g. `blue: sanitized and in bin1`.

    What must not happen before is left out. A formula with bounded operators is put into words as a whole.

    Raises:
        FormulaError: the task's formula is not co-safe.
    """
    formula = task.tree
    subject = _subject(task, model)
    phrases: dict[str, str] = {}
    if isinstance(model, ManipulationModel):
        for obj in model.objects:
            about = "" if subject else f"{model.display.obj(obj.name)} "
            phrases[holding(obj.name)] = f"{about}in the hand"
            phrases |= {at(obj.name, place.name): about + at_words(place.name, model) for place in model.locations}
            phrases |= {marked(obj.name, mark): about + mark for mark in model.marks}
    words = _goal_words(formula, phrases)
    return words_of(formula) if words is None else f"{_shown(subject, model)}: {words}" if subject else words


def at_words(place: str, model: ManipulationModel) -> str:
    """Return `in` or `on` and the location."""
    return f"{'in' if model.location(place).kind == 'bin' else 'on'} {model.display.location(place)}"


def _goal_words(formula: Formula, phrases: Mapping[str, str]) -> str | None:
    """Return what has to become true, with phrases in place of propositions; None if an operator is bounded."""
    match formula:
        case Literal(name, positive):
            return phrases.get(name, name) if positive else f"not {phrases.get(name, name)}"
        case Until(_, right, 0, None):
            return _goal_words(right, phrases)
        case Or(operands):
            words = [_goal_words(operand, phrases) for operand in operands]
            return None if None in words else " or ".join(map(str, words))
        case And(operands):
            now: list[str] = []
            later: list[str] = []
            for operand in operands:
                wanted = _goal_words(operand, phrases)
                if wanted is None:
                    return None
                (later if isinstance(operand, Until) else now).append(f"({wanted})" if " or " in wanted else wanted)
            return ", then ".join(" and ".join(words) for words in (now, later) if words)
    return None


def words_of(formula: Formula) -> str:
    """Return a formula in words, e.g. `eventually (grocer and eventually p2)`.

    It is in negation normal form: `a -> b` becomes `no a or b`.
    """
    match formula:
        case Truth(value):
            return "anything" if value else "the impossible"
        case Literal(name, positive):
            return name if positive else f"no {name}"
        case And(operands):
            return " and ".join(map(_part, operands))
        case Or(operands):
            return " or ".join(map(_part, operands))
        case Until(Truth(True), right, 1, 1):
            return f"one action later {_part(right)}"
        case Until(left, right, low, high):
            when = _steps(low, high)
            if left != TRUE:
                return f"{_part(left)} until {_part(right)}{when and f', {when}'}"
            return f"{when or 'eventually'} {_part(right)}"
        case BoundedRelease(left, right, low, high):
            unless = "" if left == FALSE else f", until {_part(left)} as well"
            return f"all the time {_steps(low, high)} {_part(right)}{unless}"


def _steps(low: int, high: int | None) -> str:
    """Return the bounds of an operator in words; empty if it has none."""
    if high is None:
        return f"after at least {low} actions" if low else ""
    if low == high:
        return f"after {low} actions"
    return f"{low} to {high} actions later" if low else f"within {high} actions"


def _part(formula: Formula) -> str:
    """Return a part of a formula in words, in brackets where it would be ambiguous without them."""
    alone = isinstance(formula, Truth | Literal) or (isinstance(formula, Until) and formula.left == TRUE)
    return words_of(formula) if alone else f"({words_of(formula)})"
