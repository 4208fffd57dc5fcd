"""`prefplan completion`: the script with which a shell completes prefplan's arguments."""

import click
from click.shell_completion import get_completion_class

from experiments.cli.command import command
from experiments.cli.status import DONE
from experiments.cli.values import Choice

SHELLS = ("bash", "fish", "zsh")


@command
@click.argument("shell", metavar="SHELL", type=Choice(SHELLS), help=f"One of {', '.join(SHELLS)}.")
def completion(shell: str) -> int:
    """Print the script that lets a shell complete commands, options and scenarios.

    Examples:
      prefplan completion bash > ~/.prefplan.bash
      prefplan completion fish > ~/.config/fish/completions/prefplan.fish

    Write it to a file that the shell reads as it starts:
      bash  prefplan completion bash > ~/.prefplan.bash
            echo 'source ~/.prefplan.bash' >> ~/.bashrc
      zsh   prefplan completion zsh > ~/.prefplan.zsh
            echo 'autoload -Uz compinit && compinit' >> ~/.zshrc
            echo 'source ~/.prefplan.zsh' >> ~/.zshrc
      fish  prefplan completion fish > ~/.config/fish/completions/prefplan.fish
    """
    program = click.get_current_context().find_root().command
    found = get_completion_class(shell)
    assert found is not None
    script = found(program, {}, "prefplan", "_PREFPLAN_COMPLETE").source()
    print(script.replace("complete -o nosort", "complete -o nosort -o filenames"))  # bash puts no space behind a folder
    return DONE
