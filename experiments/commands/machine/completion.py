"""`prefplan completion`: the script with which a shell completes prefplan's arguments."""

from __future__ import annotations

import argparse

from experiments.cli.arguments import Commands, add_command
from experiments.cli.completion import SHELLS, script
from experiments.cli.status import DONE

SWITCHED_ON = """\
Write it to a file that the shell reads as it starts:
  bash  prefplan completion bash > ~/.prefplan.bash && echo 'source ~/.prefplan.bash' >> ~/.bashrc
  zsh   prefplan completion zsh > ~/.prefplan.zsh
        echo 'autoload -Uz compinit && compinit && eval "$(<~/.prefplan.zsh)"' >> ~/.zshrc
  fish  prefplan completion fish > ~/.config/fish/completions/prefplan.fish
  tcsh  prefplan completion tcsh > ~/.prefplan.tcsh && echo 'source ~/.prefplan.tcsh' >> ~/.tcshrc"""


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan completion bash > ~/.prefplan.bash",
        "prefplan completion fish > ~/.config/fish/completions/prefplan.fish",
    )
    parser = add_command(commands, completion, *examples, more=SWITCHED_ON)
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=f"one of {', '.join(SHELLS)}")


def completion(options: argparse.Namespace) -> int:
    """Print the script that lets a shell complete commands, options and scenarios."""
    print(script(options.program, options.shell))
    return DONE
