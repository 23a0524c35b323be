"""``pitchopt check``: compute stored bounds again, from curves and multipliers alone."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.help import Command
from pitchopt.cli.options import json_option
from pitchopt.cli.values import Option
from pitchopt.errors import ComputationError

if TYPE_CHECKING:
    from pitchopt.design import Certificate

__all__ = ["command"]

_ROUNDING = 1e-9  # by which a bound may come out above the stored one, relative

_EPILOG = """\b
Examples:
  pitchopt design --max-power-loss 3% --certify deep --certify-gap 1% --out proven
  pitchopt check proven/certificates.npz
  pitchopt check proven/certificates.npz --curves table.npz

\b
Exit status 0 when every bound comes out as stored or below, 1 when one does not."""


@click.command("check", cls=Command, epilog=_EPILOG)
@click.argument("file", type=Option("file", endings=(".npz",)), metavar="CERTIFICATES.npz")
@click.option(
    "--curves",
    type=Option("file", endings=(".npz", ".csv")),
    metavar="FILE",
    help="Table of blade loads over azimuth and pitch that the bounds are to hold for, instead of "
    "those stored beside them; must be the same.",
)
@json_option
def command(**options: Any) -> int:
    """Check the proven bounds in a file of certificates.

    tradeoff and design say how far a profile is from the best possible, and store the proof. Every
    bound is computed again from the blade loads, the limits and the stored multipliers; for a
    branch and bound the whole tree of regions is gone through.  No solver is called.
    """
    import numpy as np

    from pitchopt.aero.curves import BladeCurves
    from pitchopt.cli.progress import Progress
    from pitchopt.exports import document_text, read_certificates

    certificates = read_certificates(options["file"])
    curves = None if options["curves"] is None else BladeCurves.load(options["curves"])
    rows = []
    with Progress() as progress:
        for number, (label, certificate) in enumerate(certificates.items()):
            progress(number, len(certificates), label)
            began = time.perf_counter()
            bound = certificate.check(curves)
            stored = certificate.upper_bound
            rows.append(
                {
                    "label": label,
                    "method": certificate.method,
                    "regions": None if certificate.proof is None else certificate.proof.regions,
                    "upper_bound": stored,
                    "upper_bound_checked": bound,
                    "leaves_out": certificate.left_out,
                    "about": _about(certificate),
                    "holds": bool(
                        np.isfinite([bound, stored]).all()
                        and bound <= stored + _ROUNDING * abs(stored)
                    ),
                    "seconds": time.perf_counter() - began,
                }
            )
    if options["as_json"]:
        click.echo(document_text({"file": options["file"], "certificates": rows}), nl=False)
    else:
        _print(rows)
    wrong = [row["label"] for row in rows if not row["holds"]]
    if wrong:
        raise ComputationError(
            f"certificates: the bound of {', '.join(map(str, wrong))} does not come out"
        )
    return 0


def _about(certificate: Certificate) -> str:
    """What is bounded, and for which profiles: the file's own word on it, to be read."""
    import numpy as np

    objective, limits = certificate.objective, certificate.limits
    low, high, rate = np.rad2deg([limits.lower, limits.upper, limits.pitch_rate])
    parts = [
        f"{objective.torque:g} T - {'/'.join(f'{price:g}' for price in objective.rms)} J",
        f"pitch {low:g} to {high:g} deg at {rate:g} deg/s and {limits.rotor_speed:g} rad/s",
    ]
    if np.isfinite(objective.torque_min) or np.isfinite(objective.torque_max):
        parts.append(f"mean torque {objective.torque_min:.6g} to {objective.torque_max:.6g} N m")
    if np.isfinite(objective.blade_cap):
        parts.append(f"blade RMS at most {objective.blade_cap:.6g} N m")
    if objective.travel:
        parts.append(f"travel at {objective.travel:g} N m/rad")
    if certificate.mean_pitch is not None:
        parts.append(f"mean pitch {np.rad2deg(certificate.mean_pitch):.4f} deg")
    if certificate.left_out:
        parts.append(f"without the restriction to {certificate.left_out}")
    return ", ".join(parts)


def _print(rows: list[dict[str, Any]]) -> None:
    from pitchopt.cli.tables import text_table

    header = ["certificate", "method", "regions", "stored bound", "computed again", "holds"]
    body = [
        [
            row["label"],
            row["method"],
            "-" if row["regions"] is None else str(row["regions"]),
            f"{row['upper_bound']:.9g}",
            f"{row['upper_bound_checked']:.9g}",
            "yes" if row["holds"] else "NO",
        ]
        for row in rows
    ]
    click.echo(text_table([header, *body], left=2) + "\n")
    for row in rows:
        click.echo(f"{row['label']}: {row['about']}")
