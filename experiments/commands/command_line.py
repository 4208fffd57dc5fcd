"""The command line: one program, `prefplan`."""

import os
import pkgutil
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import click
from click.shell_completion import BashComplete, add_completion_class, shell_complete

import prefplan
from experiments.cli.command import Command, call, quiet_option, verbatim
from experiments.cli.files import DISK_IS_FULL
from experiments.cli.status import DONE, FAILED, tell

SECTIONS = {"planning": "Planning", "execution": "Carrying plans out", "machine": "This machine"}
"""The folders of commands, with the heading of each in the help."""

FOLDERS = {
    module.name: folder for folder in SECTIONS for module in pkgutil.iter_modules([str(Path(__file__).parent / folder)])
}
"""The folder of each command."""

COMPLETE = "_PREFPLAN_COMPLETE"
"""Environment variable in which a shell's script asks for completions."""

EPILOG = """\
Examples:
  prefplan demo                                 the paper's arm, with videos
  prefplan front example                        the Pareto front and its plans
  prefplan plan example --max-preference 3      the cheapest within a bound
  prefplan run case_study_3 --plan preference   one plan, with a video

Exit status:
  0    done
  2    invalid arguments or input: stderr says what is valid
  3    no plan exists, or none within the bounds given
  4    the execution failed, a log was refuted, a limit came first, no disk left
  5    a log is consistent, but not proved (`prefplan verify`)
  130  interrupted by Ctrl-C

`prefplan COMMAND --help` shows the arguments of a command and more examples. Commands with --json print one JSON
object on stdout and nothing else. Colour and framed tables are for terminals only; NO_COLOR=1 turns colour off.
"""


@add_completion_class
class Bash(BashComplete):
    """Bash that puts no space behind a folder."""

    source_template = BashComplete.source_template.replace("complete -o nosort", "complete -o nosort -o filenames")


class CommandLine(click.Group):
    """All commands, each loaded when it is called or its help is shown."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands."""
        return list(FOLDERS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> Command | None:
        """Return a command."""
        if cmd_name not in FOLDERS:
            if ctx.resilient_parsing:  # a shell asks for completions
                return None
            raise click.NoSuchCommand(cmd_name, possibilities=FOLDERS, ctx=ctx)
        module = import_module(f"experiments.commands.{FOLDERS[cmd_name]}.{cmd_name}")
        found: Command = getattr(module, cmd_name)
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what each command does, by folder."""
        for folder, heading in SECTIONS.items():
            commands = [self.get_command(ctx, name) for name in FOLDERS if FOLDERS[name] == folder]
            with formatter.section(heading):
                formatter.write_dl([(str(one.name), str(one.help)) for one in commands if one is not None])


@click.group("prefplan", cls=CommandLine, invoke_without_command=True, epilog=verbatim(EPILOG), params=[quiet_option()])
@click.custom_version_option(lambda context: f"prefplan {prefplan.__version__}", help="Show the version.")
@click.pass_context
def program(context: click.Context) -> int:
    """Plan temporal tasks at the best trade-offs of cost and preference, and carry the plans out."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program and return its exit status."""
    status = DONE
    try:
        if instruction := os.environ.get(COMPLETE):
            status = shell_complete(program, {}, "prefplan", COMPLETE, instruction)
        else:
            status = call(program, "prefplan", arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        _write_nowhere()
    except OSError as error:
        if error.errno not in DISK_IS_FULL:
            raise
        _write_nowhere()
        tell(f"cannot be written: {error.filename or 'standard output'} ({error.strerror})")
        status = FAILED
    return status


def _write_nowhere() -> None:
    """Let nothing more be written to stdout: flushing at exit would fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
