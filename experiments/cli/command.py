"""What all commands share: their help, the switch `-q`, and the handling of errors."""

import inspect
import re
import sys
from collections.abc import Callable, Sequence
from typing import Any

import click

from experiments.cli.files import FullDiskError
from experiments.cli.start import missing
from experiments.cli.status import BAD_INPUT, FAILED, INTERRUPTED, QUIET, tell
from prefplan.errors import LimitError, PrefplanError


def _keep_quiet(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    if value:
        context.meta[QUIET] = True


def quiet_option() -> click.Option:
    """Return the switch that hides progress; it may stand before a command or after it."""
    told = "Show no progress, only results and errors."
    return click.Option(["-q", "--quiet"], is_flag=True, expose_value=False, callback=_keep_quiet, help=told)


def verbatim(text: str) -> str:
    """Return the text of a help in which paragraphs with indented lines, such as examples, are not wrapped."""
    return re.sub(r"^(?=\S.*\n )", "\b\n", text, flags=re.MULTILINE)


class Command(click.Command):
    """A command whose docstring is its help: the first paragraph above the options, the others below them."""

    def __init__(self, name: str | None, *, help: str, params: Sequence[click.Parameter], **settings: Any) -> None:
        """Add `-q` to the parameters."""
        summary, _, more = inspect.cleandoc(help).partition("\n\n")
        super().__init__(name, help=summary, epilog=verbatim(more), params=[*params, quiet_option()], **settings)


def command(function: Callable[..., int]) -> Command:
    """Make a command of a function that carries it out and returns its exit status."""
    return click.command(cls=Command)(function)


def call(command: click.Command, name: str, arguments: Sequence[str] | None) -> int:
    """Call a command or a group of them by its name; print an error in a sentence, and return the exit status.

    Without arguments, it is called with those of this process.
    """
    called = [name]
    try:
        with command.make_context(name, list(sys.argv[1:] if arguments is None else arguments)) as context:
            try:
                status: int = command.invoke(context)
                return status
            finally:
                called += filter(None, [context.invoked_subcommand])
    except click.exceptions.Exit as end:  # the help or the version was shown
        return end.exit_code
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else " ".join(called)
        tell(" ".join(error.format_message().split()), who=path)
        print(f"Usage: `{path} --help`", file=sys.stderr)
        return BAD_INPUT
    except PrefplanError as error:
        from prefplan.front import UnfinishedError  # loads numpy, which other errors may do without

        tell(error)
        return FAILED if isinstance(error, (UnfinishedError, LimitError, FullDiskError)) else BAD_INPUT
    except MemoryError:
        tell("out of memory")
        return FAILED
    except ModuleNotFoundError as error:
        return missing(error, command=called[-1])
    except KeyboardInterrupt:
        tell("interrupted")
        return INTERRUPTED
