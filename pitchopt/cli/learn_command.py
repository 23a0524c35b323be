"""``pitchopt learn``: a profile learned from measured loads alone."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.help import Command, section
from pitchopt.cli.learn_turbine import chosen_plant, learn_turbine, turbine_options
from pitchopt.cli.options import build_case, case_options, result_options
from pitchopt.cli.values import (
    DRIFT_ROTATIONS,
    Given,
    Option,
    as_share,
    as_share_or_none,
    between,
    positive,
    torque,
    whole,
    wind_drift,
    wind_ramp,
    wind_step,
)
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.studies.learning import LearningResult, LearningSettings

__all__ = ["command"]

_EXCLUSIVE = (("max_power_loss", "mean_torque"), ("wind_step", "wind_ramp", "wind_drift"))

_EPILOG = """\b
Examples:
  pitchopt learn --wind-step 22:+2
  pitchopt learn --learner paper --wind-step 22:+2 --out figure-8
  pitchopt learn --noise 2% --delay 3 --dropout 1% --json
  pitchopt learn --case nrel-5mw --wind-speed 15 --mean-torque rated
  pitchopt learn --separate --blade-chord 1.03 --rotations 100
  pitchopt learn --checkpoint run.npz --rotations 200
  pitchopt learn --plant dynamic --case nrel-5mw --wind-speed 9 --rotations 20
  pitchopt learn --plant dynamic --case nrel-5mw --wind-speed 15 --rotor controlled
      --turbulence B --averaged 20 --amplitude-deg 1.5 --rotations 12

\b
Files: learning.json, learning.csv (a row a rotation), profile.csv and profiles.npz (with
--separate profile_b1.csv ...), learning.png, profiles.png, with the paper's
learner contraction.png. pitchopt export takes profiles.npz with --point learned. With
--plant dynamic: learning.json, learning.csv, profile.csv, learning.png.

\b
Rotations count from the end of the experiment, in which the learner perturbs the
pitch. A cap on the blade load is left out: no learner measures that load.

\b
See also: design (with the model), export, simulate."""


def _run_options(function: Any) -> Any:
    """Learner, length and start."""
    function = section(
        "The paper's learner",
        click.option(
            "--learning-rate", type=Option("x", positive(1, "-")), metavar="KAPPA",
            help="Share of a step that is taken.  [default: 0.3]",
        ),
        click.option(
            "--damping", type=Option("x", between(0, 1e6, "-")), metavar="NU",
            help="Relative to the mean eigenvalue of D'D, D the identified response of the loads "
            "to pitch.  [default: 0]",
        ),
        click.option(
            "--smoothing", type=Option("x", positive(1, "-")), metavar="Q",
            help="Weight of a rotation's measured means.  [default: 0.5]",
        ),
    )(function)  # fmt: skip
    return section(
        "Learner",
        click.option(
            "--learner", type=click.Choice(["adaptive", "paper"]), default="adaptive",
            show_default=True,
            help="Tracked model and constrained steps, or the fixed gain of the paper.",
        ),
        click.option(
            "--rotations", type=Option("n", whole(1, 100_000)), metavar="N", default="50",
            show_default=True, help="Rotations after the experiment.",
        ),
        click.option(
            "--max-power-loss", type=Option("share", as_share), metavar="SHARE",
            help="Set-point: this share below the largest mean torque of each wind.  "
            "[default: 7%]",
        ),
        click.option(
            "--mean-torque", type=Option("torque", torque, names=("rated",)), metavar="NM|rated",
            help="Set-point: this mean torque in any wind [N m].",
        ),
        click.option(
            "--start-pitch-deg", type=Option("deg", between(-180, 180, "deg")), metavar="DEG",
            help="Constant pitch to start from.  [default: that with the set-point's torque]",
        ),
        click.option(
            "--amplitude-deg", type=Option("deg", positive(20, "deg")), metavar="DEG",
            help="Perturbations in the experiment.  [default: 0.5]",
        ),
        click.option("--separate", is_flag=True, help="One profile for each blade."),
        click.option(
            "--seed", type=Option("n", whole(0, 2**63 - 1)), metavar="N", default="0",
            show_default=True, help="Seed of noise, dropout and drift.",
        ),
        click.option(
            "--checkpoint", type=Option("file", endings=(".npz",)), metavar="FILE.npz",
            help="Saved after every rotation; a run whose file exists goes on from it.",
        ),
    )(function)  # fmt: skip


def _plant_options(function: Any) -> Any:
    """Sensors, wind and a blade that differs."""
    share = Option("share", as_share_or_none)
    function = section(
        "What changes or differs (static rotor)",
        click.option(
            "--wind-step", type=Option("step", wind_step), metavar="ROTATION:CHANGE",
            help="Wind speed changes after so many rotations, such as 22:+2 [m/s].",
        ),
        click.option(
            "--wind-ramp", type=Option("ramp", wind_ramp), metavar="FIRST-LAST:CHANGE",
            help="Wind speed changes between two rotations, such as 20-30:+2 [m/s].",
        ),
        click.option(
            "--wind-drift", type=Option("drift", wind_drift), metavar="STD[:ROTATIONS]",
            help="Wind speed drifts at random, with this standard deviation [m/s] and "
            f"correlation.  [default of ROTATIONS: {DRIFT_ROTATIONS:g}]",
        ),
        click.option(
            "--blade-pitch-offset-deg", type=Option("deg", between(-20, 20, "deg")),
            metavar="DEG", help="What the pitch of blade 1 is above the commanded one.",
        ),
        click.option(
            "--blade-chord", type=Option("x", positive(10, "-")), metavar="FACTOR",
            help="Factor on the chord of blade 1.",
        ),
    )(function)  # fmt: skip
    return section(
        "Sensors",
        click.option(
            "--noise", type=share, metavar="SHARE", default="0", show_default=True,
            help="Standard deviation of the measurement noise: 0.02 or 2% of each load's RMS "
            "at the starting pitch.",
        ),
        click.option(
            "--noise-of", type=click.Choice(["rms", "mean"]), default="rms",
            show_default=True, help="Noise as a share of each load's RMS or of its mean.",
        ),
        click.option(
            "--quantisation", type=share, metavar="SHARE", default="0", show_default=True,
            help="Step of the measured loads, as a share of each load's RMS.",
        ),
        click.option(
            "--delay", type=Option("n", whole(0, 100_000)), metavar="SAMPLES", default="0",
            show_default=True, help="Lag of the measurements; the learner is told.",
        ),
        click.option(
            "--dropout", type=share, metavar="SHARE", default="0", show_default=True,
            help="Probability of a sample to be lost.",
        ),
    )(function)  # fmt: skip


@click.command("learn", cls=Command, epilog=_EPILOG)
@_run_options
@_plant_options
@turbine_options
@case_options
@result_options
def command(**options: Any) -> int:
    """A pitch profile learned from measured loads alone.

    A learner perturbs the pitch, sees the four loads of the rotor (torque, tilt, yaw, thrust) and
    nothing else, and changes the profile from rotation to rotation so that they vary less at a
    given mean torque. It turns the static rotor of a case, or the dynamic turbine. Prints what is
    left of the variation rotation by rotation, beside constant pitch and the profile that is
    designed with the model.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.learn_tables import print_learning
    from pitchopt.cli.progress import Progress
    from pitchopt.studies.learning import learn, learning_document

    if isinstance(options["blade_cap"], Given) and options["blade_cap"].value is not None:
        raise InputError(
            f"--blade-cap: got {options['blade_cap'].value:g}, expected none: a learner measures "
            "no blade load"
        )
    plant = chosen_plant(options)
    case = build_case(options).with_values({"objective.blade_cap": None})
    settings = _settings(case, options)
    if plant == "dynamic":
        return learn_turbine(case, settings, options)
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "learn", case.name, as_json=as_json)
    with Progress() as progress:
        result = learn(case, settings, checkpoint=options["checkpoint"], progress=progress)
    document = learning_document(result, case.settings())
    output.deliver(
        document,
        "learning.json",
        folder=folder,
        files=lambda: _files(result, document, plots=not options["no_plots"]),
        began=began,
        as_json=as_json,
        show=lambda found: print_learning(case, found),
    )
    references = [("design", result.reference.design)]
    if result.reference_after is not None:
        references.append(("design after the change", result.reference_after.design))
    output.warn_about(references, case)
    return 0


def _settings(case: Case, options: dict[str, Any]) -> LearningSettings:
    """Settings of the run."""
    import numpy as np

    from pitchopt.cli.design_command import rated_torque
    from pitchopt.studies.learning import (
        BladeDifference,
        LearningSettings,
        WindDrift,
        WindRamp,
        WindStep,
    )

    def angle(name: str) -> float | None:
        value = options[name]
        return None if value is None else float(np.deg2rad(value))

    for group in _EXCLUSIVE:
        flags = ["--" + name.replace("_", "-") for name in group if options[name] is not None]
        if len(flags) > 1:
            raise InputError(f"{flags[1]}: got it together with {flags[0]}, expected one of them")
    speed = case.wind.speed
    wind: WindStep | WindRamp | WindDrift | None = None
    if options["wind_step"] is not None:
        rotation, change = options["wind_step"]
        wind = WindStep(speed=speed, change=change, rotation=rotation)
    if options["wind_ramp"] is not None:
        first, last, change = options["wind_ramp"]
        wind = WindRamp(speed=speed, change=change, first=first, last=last)
    if options["wind_drift"] is not None:
        std, rotations = options["wind_drift"]
        wind = WindDrift(
            speed=speed, std=std, rotations_correlation=rotations, seed=options["seed"]
        )
    offset, chord = options["blade_pitch_offset_deg"], options["blade_chord"]
    difference = None
    if offset is not None or chord is not None:
        difference = BladeDifference(
            pitch_offset=angle("blade_pitch_offset_deg") or 0.0,
            chord=1.0 if chord is None else chord,
        )
    names = (
        *("learner", "rotations", "max_power_loss", "mean_torque", "learning_rate", "damping"),
        *("smoothing", "separate", "noise", "noise_of", "quantisation", "delay", "dropout"),
    )
    given = {name: options[name] for name in names}
    if given["mean_torque"] == "rated":
        given["mean_torque"] = rated_torque(case)
    return LearningSettings(
        **given,
        start_pitch=angle("start_pitch_deg"),
        amplitude=angle("amplitude_deg"),
        seed=options["seed"],
        wind=wind,
        difference=difference,
    )


def _files(
    result: LearningResult, document: dict[str, Any], *, plots: bool
) -> dict[str, bytes | str]:
    from pitchopt.exports import profile_csv
    from pitchopt.studies.learning import learned_profiles, learning_csv

    case, profile, speed = result.case, result.learned.profile, result.rotor_speed
    files: dict[str, bytes | str] = {"learning.csv": learning_csv(document)}
    if profile.ndim == 1:
        files["profile.csv"] = profile_csv(result.azimuth, profile, rotor_speed=speed)
        files["profiles.npz"] = learned_profiles(result, case.settings()).to_bytes()
    else:
        for blade, own in enumerate(profile, start=1):
            name = f"profile_b{blade}.csv"
            files[name] = profile_csv(result.azimuth, own, rotor_speed=speed)
    if plots:
        from pitchopt.plotting import (
            contraction_figure,
            learned_profiles_figure,
            learning_figure,
            png,
        )

        title = f"{case.name}, {result.settings.learner} learner"
        name = case.weights.name
        files["learning.png"] = png(learning_figure(result, weights_name=name, title=title))
        files["profiles.png"] = png(learned_profiles_figure(result, title=title))
        if result.loop is not None:
            files["contraction.png"] = png(contraction_figure(result.loop, title=title))
    return files
