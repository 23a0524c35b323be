"""What commands share about their results: folders, plots, closing lines."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.design import Design, Tradeoff

__all__ = [
    "case_line",
    "closing",
    "deliver",
    "model_lines",
    "out_folder",
    "save",
    "warn_about",
    "wind_plot",
]


def out_folder(out: str | None, command: str, name: str, *, as_json: bool) -> Path | None:
    """Folder for the files, checked before the computation; None for no files.

    `name` is that of the case or the turbine.
    """
    from pitchopt.exports import check_folder

    if out is None:
        if as_json:
            return None
        out = f"{command}-{name.replace('/', '-').replace(' ', '-')}"
    if not out.strip():
        raise InputError(f"--out: got {out!r}, expected a folder, '.' for the current one")
    return check_folder(out, "--out")


def case_line(case: Case, settings: Mapping[str, Any]) -> str:
    """What is designed, in two lines."""
    wind, limits, objective = settings["wind"], settings["limits"], settings["objective"]
    rpm = settings["operation"]["rotor_speed_rpm"]
    if case.table is not None:
        first = f"curves {case.curves}, {rpm:.4g} rpm"
    else:
        shear = {
            "power": f"power-law shear {wind['shear_exponent']:g}",
            "cubic": f"cubic shear {wind['shear_exponent']:g}",
            "log": f"log law, roughness {wind['roughness_length']:g} m",
            "none": "no shear",
        }[wind["shear"]]
        if wind["disc"]:
            shear = f"speed over the disc from {wind['disc']}"
        tower = "tower shadow" if wind["tower_shadow"] else "no tower shadow"
        first = (
            f"turbine {case.turbine}, {wind['speed']:g} m/s, {shear}, {tower}, {rpm:.4g} rpm, "
            f"induction {settings['aero']['induction']}"
        )
    cap, harmonics = objective["blade_cap"], objective["harmonics"]
    second = (
        f"{limits['positions']} rotor positions, pitch {limits['pitch_min_deg']:g} to "
        f"{limits['pitch_max_deg']:g} deg at {limits['pitch_rate_deg']:g} deg/s, weights "
        f"{objective['weights_name']}"
        + ("" if cap == "none" else f", blade RMS at most {cap:g} of constant pitch")
        + ("" if harmonics == "none" else f", harmonics up to {harmonics}P")
        + ("" if not objective["travel_penalty"] else f", travel {objective['travel_penalty']:g}")
    )
    return f"{case.name}: {first}\n{second}"


def model_lines(model: Mapping[str, Any]) -> list[str]:
    """What is known of the aerodynamic model at the constant pitch, one line each."""
    lines = []
    if "power_coefficient" in model:
        lines.append(
            f"at the constant pitch: power coefficient {model['power_coefficient']:.4f}, thrust "
            f"coefficient {model['thrust_coefficient']:.4f}"
        )
    if model.get("polar_fit_lift_error") is not None:
        lines.append(
            f"polar fits: largest error in lift {model['polar_fit_lift_error']:.4f}, in drag "
            f"{model['polar_fit_drag_error']:.4f}"
        )
    if "frozen_fit_error" in model:
        fit, turn = model["frozen_fit_error"], model["frozen_projection_error"]
        shares = ", ".join(
            f"{name} {100 * fit[name]:.1f} % (fits) {100 * turn[name]:.2f} % (prebend and sweep)"
            for name in fit
        )
        lines.append(f"frozen curves 3 deg from the mean pitch are off by at most: {shares}")
    return [*lines, ""] if lines else []


def save(folder: Path | None, files: Mapping[str, bytes | str]) -> list[str]:
    """Write the files, if there is a folder for them; returns their paths."""
    if folder is None:
        return []
    from pitchopt.exports import write_files

    return [str(path) for path in write_files(folder, files)]


def wind_plot(case: Case) -> dict[str, bytes]:
    """Picture of the wind over the disc; none for a table of curves."""
    if case.table is not None:
        return {}
    from matplotlib.figure import Figure

    from pitchopt.plotting import plot_wind_field, png
    from windfield import WindFieldError, sample_disc

    rotor = case.rotor()
    try:
        sample = sample_disc(
            case.wind_field(),
            rotor.radius,
            hub_height=rotor.hub_height,
            x=-rotor.overhang,
            rings=60,
            azimuths=180,
            closed=True,
        )
    except WindFieldError:
        return {}  # a disc file that covers the blades but not the whole disc
    figure = Figure(figsize=(6.0, 4.8), layout="constrained")
    plot_wind_field(sample, ax=figure.add_subplot())
    return {"wind.png": png(figure)}


def closing(folder: Path | None, files: Sequence[str], seconds: float) -> None:
    """The last lines of a command."""
    where = "" if folder is None else f"{len(files)} files in {folder}/, "
    click.echo(f"{where}{seconds:.1f} s")


def deliver(
    document: dict[str, Any],
    name: str,
    *,
    folder: Path | None,
    files: Callable[[], Mapping[str, bytes | str]],
    began: float,
    as_json: bool,
    show: Callable[[dict[str, Any]], None],
) -> None:
    """Files, then the document or its tables and the closing line.

    Parameters
    ----------
    document : dict
        Gets its ``seconds``.
    name : str
        Of its file.
    folder : Path or None
        For the files; None for none.
    files : callable
        Makes the other files, if there is a folder.
    began : float
        `time.perf_counter` at the start.
    as_json : bool
        The document on standard output, in place of the tables.
    show : callable
        Prints the tables of the document.
    """
    from pitchopt.exports import document_text

    made = files() if folder is not None else {}
    document["seconds"] = time.perf_counter() - began
    written = save(folder, {**made, name: document_text(document)})
    if as_json:
        click.echo(document_text(document), nl=False)
    else:
        show(document)
        closing(folder, written, document["seconds"])


def warn_about(designs: Sequence[tuple[str, Design]], case: Case) -> None:
    """One line on standard error for every design that is not an answer in full."""
    from pitchopt.design import Status

    for label, design in designs:
        if design.status.ok:
            continue
        hint = ""
        if design.status is Status.INFEASIBLE and case.objective.blade_cap is not None:
            hint = "; ask for less torque, or give a larger --blade-cap or none"
        text = " ".join(design.message.split())
        click.echo(f"pitchopt: {label}: {design.status.value}: {text}{hint}", err=True)


def failed(result: Tradeoff) -> bool:
    """True when nothing of a trade-off can be used as an answer."""
    return not result.power_max.status.ok or not any(p.status.ok for p in result.points)
