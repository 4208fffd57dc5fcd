"""How a program ends and what it tells its user: exit statuses and messages, in which foreign text is escaped."""

import os
import re
import sys

from prefplan.text.layout import printable, printable_lines

DONE, BAD_INPUT, NO_PLAN, FAILED, CONSISTENT, INTERRUPTED = 0, 2, 3, 4, 5, 130

QUIET = "prefplan.quiet"
"""Key of the click context's `meta` under which `-q` is kept."""

FOREIGN_BREAK = re.compile(r"\n(?! {4})")
"""A line break from foreign text: further lines of a message are indented by four, of a table or a verdict by less."""

LONGEST_LINE = 2000
"""Most characters of a line of a message; a longer one, such as that of a formula of a megabyte, loses its middle."""


def is_quiet() -> bool:
    """Return whether the present command, if any, was called with `-q`."""
    import click  # `program` says if it is missing

    context = click.get_current_context(silent=True)
    return context is not None and QUIET in context.meta


def say(text: object, *, end: str = "\n") -> None:
    """Print a result on stdout, with its control characters escaped."""
    print(printable_lines(str(text)), end=end, flush=True)


def tell(message: object, *, who: str = "prefplan") -> None:
    """Print a message on stderr, after the name of its sender, with its control characters escaped."""
    text = "\n".join(map(_shortened, printable_lines(FOREIGN_BREAK.sub(r"\\n", str(message))).split("\n")))
    try:
        print(f"{printable(who)}: {text}", file=sys.stderr, flush=True)
    except OSError:  # a full disk: the message is lost, but the exit status stays, also when stderr is closed
        sys.stderr = open(os.devnull, "w")


def _shortened(line: str) -> str:
    half = LONGEST_LINE // 2
    return line if len(line) <= LONGEST_LINE else f"{line[:half]} ... {line[-half:]}"
