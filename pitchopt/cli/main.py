"""The program: commands, exit status, and errors as one line.

Exit status 0 on success, 2 for bad input and for a demand that no profile meets (a mean torque
out of reach, limits that leave nothing), 1 for a failed computation, 130 when interrupted.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Sequence

import click
from click.shell_completion import CompletionItem

from pitchopt import __version__
from pitchopt.cli.help import nearest
from pitchopt.errors import InfeasibleError, InputError, PitchoptError

__all__ = ["main", "program"]

_COMMANDS = {
    "tradeoff": "What less variation of the loads costs in mean torque: a curve.",
    "design": "One pitch profile: for a price, a loss of torque, or a torque.",
    "robust": "One pitch profile for several winds.",
    "schedule": "A table of pitch profiles over wind speed.",
    "learn": "A pitch profile learned from measured loads alone.",
    "simulate": "The moving turbine in steady wind or turbulence; fatigue loads.",
    "tune": "Controllers tuned by simulation, by a choice of tuners.",
    "compare": "All methods on one turbine in the same winds, side by side.",
    "sensitivity": "What a changed limit, price or wind would do to a design.",
    "tower": "A tower designed together with its controller; cost of energy.",
    "check": "Proven bounds computed again from their certificates.",
    "export": "Profiles and controllers as files that other programs read.",
    "turbines": "The reference turbines; templates of case files.",
    "completion": "Completion of commands, options and names in your shell.",
}
_SECTIONS = {
    "Design a pitch profile": ("tradeoff", "design", "robust", "schedule", "sensitivity"),
    "Learn, simulate, tune": ("learn", "simulate", "tune", "compare", "tower"),
    "Files and set-up": ("turbines", "export", "check", "completion"),
}
_OTHER = "Other commands"

_EPILOG = """\b
First steps:
  pitchopt tradeoff --out demo                 the built-in case: what less variation costs
  pitchopt turbines                            the reference turbines
  pitchopt turbines --template my-turbine.yaml > my-case.toml     an own windIO turbine
  pitchopt tradeoff --case my-case.toml

\b
More:
  pitchopt design --case iea-15-240 --wind-speed 9 --max-power-loss 2% --out design
  pitchopt design --case nrel-5mw --wind-speed 15 --mean-torque rated
  pitchopt export design/profiles.npz --format harmonics
  pitchopt learn --wind-step 22:+2
  pitchopt simulate --wind-speed 12 --turbulence B --seeds 6 --controller ipc
  pitchopt tune --problem individual-pitch --method bayes
  pitchopt compare --quick --report
  pitchopt tower --quick --out tower

\b
"pitchopt COMMAND --help" explains a command: its options, files and examples. A case is
a turbine with its wind, limits and weights: a built-in name, or a TOML file. Every
command prints tables, or one JSON document with --json, and writes files to --out.

\b
Exit status: 0 success, 1 failed computation, 2 bad input or a demand that no profile
meets (one line says what), 130 interrupted."""


class _Commands(click.Group):
    """Commands whose modules load when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  part of click's interface
        """Names, in the order of the help."""
        return list(_COMMANDS)

    def get_command(
        self,
        ctx: click.Context,  # noqa: ARG002  part of click's interface
        cmd_name: str,
    ) -> click.Command | None:
        """A command, its module loaded."""
        if cmd_name not in _COMMANDS:
            return None
        module = importlib.import_module(f"pitchopt.cli.{cmd_name}_command")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that the arguments begin with, or an error that names the nearest."""
        if args and args[0] not in _COMMANDS and not ctx.resilient_parsing:
            ctx.fail(
                f"command: got {args[0]!r}, expected one of {', '.join(_COMMANDS)}"
                + nearest(args[0], _COMMANDS, cutoff=0.5)
            )
        return super().resolve_command(ctx, args)

    def format_commands(
        self,
        ctx: click.Context,  # noqa: ARG002  part of click's interface
        formatter: click.HelpFormatter,
    ) -> None:
        """Commands and what they do, no module loaded."""
        placed = {name for names in _SECTIONS.values() for name in names}
        other = tuple(name for name in _COMMANDS if name not in placed)
        for title, names in {**_SECTIONS, _OTHER: other}.items():
            if names:
                with formatter.section(title):
                    formatter.write_dl([(name, _COMMANDS[name]) for name in names])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Commands with what they do, no module loaded; options of the program."""
        found = [
            CompletionItem(name, help=text)
            for name, text in _COMMANDS.items()
            if name.startswith(incomplete)
        ]
        return found + click.Command.shell_complete(self, ctx, incomplete)


@click.group(
    cls=_Commands,
    invoke_without_command=True,
    epilog=_EPILOG,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="pitchopt")
@click.pass_context
def program(ctx: click.Context) -> None:
    """Individual pitch profiles for wind turbines.

    Given a turbine, a wind field over its rotor disc and the limits of its pitch actuators,
    find how each blade is to be pitched over a turn so that the loads on the rotor vary less,
    what that costs in mean torque, and how far this is from the best possible.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def _say(message: object, where: str = "pitchopt") -> None:
    with contextlib.suppress(OSError):
        click.echo(f"{where}: {' '.join(str(message).split())}", err=True)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program.

    Parameters
    ----------
    args : sequence of str, optional
        Arguments without the program's name; those of the process by default.

    Returns
    -------
    int
        Exit status.
    """
    words = list(sys.argv[1:] if args is None else args)
    if words[:1] == ["help"]:
        words = [*words[1:2], "--help"]
    try:
        status = program.main(args=words, prog_name="pitchopt", standalone_mode=False)
        sys.stdout.flush()
    except click.NoSuchOption as error:
        context = error.ctx
        where = "pitchopt" if context is None else context.command_path
        known = [] if context is None else [o for p in context.command.params for o in p.opts]
        hint = nearest(error.option_name, known, cutoff=0.7)
        _say(f"no such option {error.option_name}{hint} (see {where} --help)", where)
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        where = "pitchopt" if context is None else context.command_path
        _say(f"{error.format_message()} (see {where} --help)", where)
        return 2
    except (click.Abort, KeyboardInterrupt):
        _say("interrupted")
        return 130
    except (InputError, InfeasibleError) as error:
        _say(error)
        return 2
    except PitchoptError as error:
        _say(error)
        return 1
    except BrokenPipeError:
        # the reader of standard output has gone; keep the interpreter from writing to it again
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
    except Exception as error:
        if os.environ.get("PITCHOPT_TRACEBACK"):
            raise
        if isinstance(error, ValueError) and type(error).__module__.startswith("windfield"):
            _say(f"wind: {error}")
            return 2
        what = f"{type(error).__name__}: {error}"
        _say(f"failed: {what} (PITCHOPT_TRACEBACK=1 shows where)")
        return 1
    return status if isinstance(status, int) else 0
