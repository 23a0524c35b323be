"""The program: commands, exit status, and errors as one line.

Exit status 0 on success, 2 for bad input, 1 for a failed computation, 130 when interrupted.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Sequence

import click

from pitchopt import __version__
from pitchopt.errors import InputError, PitchoptError

__all__ = ["main", "program"]

_COMMANDS = {
    "tradeoff": "Trade-off between mean torque and load variation: table, JSON, CSV, plots.",
    "design": "One pitch profile: for a price, a loss of torque, or a mean torque.",
    "robust": "One pitch profile for several winds: weighted, or for the largest regret.",
    "schedule": "A table of pitch profiles over wind speed, with bounded change.",
    "learn": "A pitch profile learned from measured loads alone, beside the designed one.",
    "simulate": "The turbine in turbulence: statistics, damage-equivalent loads, time series.",
    "tune": "Controllers tuned by simulation: zeroth-order, Bayesian, and others beside them.",
    "compare": "All methods on one turbine in the same winds: one table, and where each pays.",
    "sensitivity": "What a changed limit, price or wind would do to an optimum, beside the truth.",
    "tower": "A tower designed together with its controller: estimates, truth, cost of energy.",
    "check": "Compute stored bounds again, from curves and multipliers alone.",
    "export": "A profile for CSV, AeroDyn or ROSCO; individual pitch control for ROSCO.",
    "turbines": "What the catalogue holds; templates of case files.",
}

_EPILOG = """\b
Examples:
  pitchopt tradeoff --case biegel2011 --out demo
  pitchopt design --case nrel-5mw --wind-speed 9 --max-power-loss 2%
  pitchopt design --case nrel-5mw --wind-speed 15 --mean-torque rated
  pitchopt design --max-power-loss 3% --certify deep --certify-gap 1% --out proven
  pitchopt check proven/certificates.npz
  pitchopt learn --wind-step 22:+2
  pitchopt simulate --wind-speed 12 --turbulence B --seeds 6
  pitchopt tune --problem speed-regulator --method zoo
  pitchopt compare --report
  pitchopt sensitivity --case nrel-5mw --wind-speed 15 --mu 3
  pitchopt tower --quick --out tower
  pitchopt turbines --template nrel-5mw > my-case.toml
  pitchopt export demo/profiles.npz --point knee --format harmonics

\b
Exit status: 0 success, 1 failed computation, 2 bad input (one line says what),
130 interrupted."""


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

    def format_commands(
        self,
        ctx: click.Context,  # noqa: ARG002  part of click's interface
        formatter: click.HelpFormatter,
    ) -> None:
        """Commands and what they do, no module loaded."""
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))


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
    find the pitch profile over azimuth that trades mean torque against the variation of
    torque, tilt, yaw and thrust, and bound how far it is from the best possible.
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
    try:
        status = program.main(
            args=None if args is None else list(args), prog_name="pitchopt", standalone_mode=False
        )
        sys.stdout.flush()
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        where = "pitchopt" if context is None else context.command_path
        _say(f"{error.format_message()} (see {where} --help)", where)
        return 2
    except (click.Abort, KeyboardInterrupt):
        _say("interrupted")
        return 130
    except InputError as error:
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
