"""``pitchopt completion``: the script with which a shell completes commands, options and names."""

from __future__ import annotations

import click

from pitchopt.cli.completing import SHELLS, script
from pitchopt.cli.help import Command

__all__ = ["command"]

_EPILOG = """\b
Examples:
  echo 'eval "$(pitchopt completion bash)"' >> ~/.bashrc
  echo 'eval "$(pitchopt completion zsh)"' >> ~/.zshrc
  pitchopt completion fish > ~/.config/fish/completions/pitchopt.fish

\b
Then, in a new shell, the tabulator key completes commands, options, cases, turbines,
controllers, tuners and files:
  pitchopt tradeoff --case iea<TAB>
bash has to be 4.4 or newer; zsh needs compinit, which most set-ups call."""


@click.command("completion", cls=Command, epilog=_EPILOG)
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> int:
    """The script with which a shell completes the command line.

    Prints it on standard output; the examples say where it goes.
    """
    click.echo(script(shell))
    return 0
