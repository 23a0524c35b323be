"""The three families of quadratic programs: estimates beside optima solved again."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import click

from pitchopt.cli.tables import text_table
from pitchopt.errors import InputError

__all__ = ["run_quadratic"]

_OWN = {"problem", "out", "as_json", "no_plots"}
_SHOWN = (0.1, 0.5, 1.0)
_STEPS = 51


def run_quadratic(options: dict[str, Any]) -> int:
    """The work of ``pitchopt sensitivity --problem quadratic``."""
    began = time.perf_counter()
    context = click.get_current_context()
    for name in context.params:
        source = context.get_parameter_source(name)
        if name not in _OWN and source is click.core.ParameterSource.COMMANDLINE:
            option = next(p.opts[0] for p in context.command.params if p.name == name)
            raise InputError(
                f"{option}: got it with --problem quadratic, which takes no such option"
            )
    import numpy as np

    from pitchopt.cli import output
    from pitchopt.studies.sensitivity import (
        active_set_program,
        coupling_programs,
        estimated_curve,
        linearity_programs,
        quadratic_record,
    )

    dc = np.round(np.linspace(0.0, 1.0, _STEPS), 12)
    families = {
        "c2": ("objective that curves in x (C2)", linearity_programs()),
        "c4": ("objective that couples x2 and c (C3, figure C4)", coupling_programs()),
        "c5": ("constraint that becomes active (C4, figure C5)", (active_set_program(),)),
    }
    curves = {
        key: [estimated_curve(program, dc) for program in programs]
        for key, (_, programs) in families.items()
    }
    document = {
        "problem": "quadratic",
        "families": [
            {"key": key, "title": title, "curves": [quadratic_record(c) for c in curves[key]]}
            for key, (title, _) in families.items()
        ],
    }
    folder = output.out_folder(
        options["out"], "sensitivity", "quadratic", as_json=options["as_json"]
    )

    def files() -> dict[str, bytes | str]:
        if options["no_plots"]:
            return {}
        from pitchopt.plotting import estimates_figure, png

        return {
            f"{key}.png": png(estimates_figure(curves[key], title=title))
            for key, (title, _) in families.items()
        }

    output.deliver(
        document,
        "sensitivity.json",
        folder=folder,
        files=files,
        began=began,
        as_json=options["as_json"],
        show=_show,
    )
    return 0


def _show(document: Mapping[str, Any]) -> None:
    for family in document["families"]:
        rows = [["", "dc", "solved again", "first-order", "high-order"]]
        notes = []
        for curve in family["curves"]:
            for k, dc in enumerate(curve["dc"]):
                if dc in _SHOWN:
                    numbers = (curve[key][k] for key in ("truth", "first_order", "high_order"))
                    rows.append([curve["name"], f"{dc:g}", *(f"{value:.3f}" for value in numbers)])
            notes += [
                f"{curve['name']}: {name} looks broken from dc = {dc:g}"
                for name, dc in curve["broken"].items()
            ]
        click.echo("\n".join([family["title"], text_table(rows), *notes, ""]))
