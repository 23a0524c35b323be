"""The NREL 5 MW baseline: a plain transcription of its steps, and OpenFAST's own commands."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path

import numpy as np
import pytest
from control_factories import GEAR, FloatArray, measured, pitches
from scipy.interpolate import CubicSpline

from pitchopt.control import nrel_5mw_baseline
from pitchopt.control import signals as s

STEP = 0.0125


class PlainBaseline:
    """The steps of the baseline controller, one after the other, from its description."""

    def __init__(self, speed: float, pitch: float, torque: float) -> None:
        self.filtered, self.pitch, self.torque = speed, pitch, torque
        factor = 1.0 / (1.0 + pitch / 0.1099965)
        error = speed - 122.9096
        wanted = (pitch - factor * 0.01882681 * error) / (factor * 0.008068634)
        self.integral = max(wanted, 0.0) - error * STEP

    def call(self, speed: float) -> tuple[float, float]:
        keep = np.exp(-1.570796 * STEP)
        self.filtered = (1 - keep) * speed + keep * self.filtered
        w = self.filtered
        rated = 5296610.0 / 121.6805
        synchronous = 121.6805 / 1.1
        slope = rated / (121.6805 - synchronous)
        k = 2.332287
        end = (slope - np.sqrt(slope * (slope - 4 * k * synchronous))) / (2 * k)
        if w >= 121.6805 or self.pitch >= np.radians(1.0):
            torque = 5296610.0 / w
        elif w <= 70.16224:
            torque = 0.0
        elif w < 91.21091:
            torque = k * 91.21091**2 / (91.21091 - 70.16224) * (w - 70.16224)
        elif w < end:
            torque = k * w**2
        else:
            torque = slope * (w - synchronous)
        torque = min(torque, 47402.91)
        self.torque += np.clip(torque - self.torque, -15000.0 * STEP, 15000.0 * STEP)
        factor = 1.0 / (1.0 + self.pitch / 0.1099965)
        error = w - 122.9096
        top = np.radians(90.0) / (factor * 0.008068634)
        self.integral = float(np.clip(self.integral + error * STEP, 0.0, top))
        pitch = factor * (0.01882681 * error + 0.008068634 * self.integral)
        pitch = np.clip(pitch, 0.0, np.radians(90.0))
        change = np.radians(8.0) * STEP
        self.pitch += float(np.clip(pitch - self.pitch, -change, change))
        return self.torque, self.pitch


def test_steps_of_the_baseline() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 300.0, STEP)
    speed = 118.0 + 12.0 * np.sin(0.05 * t) + 6.0 * np.sin(0.4 * t) - 30.0 * (np.abs(t - 200) < 9)
    speed += rng.standard_normal(t.size)
    plain = PlainBaseline(speed[0], 0.05, 30000.0)
    controller = nrel_5mw_baseline()
    controller.start(
        STEP, measured(rotor_speed=speed[0] / GEAR, pitch=0.05, generator_torque=30000.0)
    )
    expected, got = [], []
    for value in speed:
        expected.append(plain.call(value))
        command = controller.command(measured(rotor_speed=value / GEAR))
        got.append((command[s.TORQUE], pitches(command)[0]))
        assert np.all(pitches(command) == pitches(command)[0])
    torques, angles = np.array(expected).T
    assert np.ptp(torques) > 4e4 and np.ptp(angles) > 0.2 and np.min(angles) == 0.0
    assert np.allclose(np.array(got)[:, 0], torques, rtol=0, atol=1e-6)
    assert np.allclose(np.array(got)[:, 1], angles, rtol=0, atol=1e-11)


def series(path: Path) -> dict[str, FloatArray]:
    with gzip.open(path, "rt") as file:
        rows = list(csv.reader(file))
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))


@pytest.mark.parametrize(
    ("name", "pitch_error", "torque_error"),
    [
        # rotor speed stored at 10 Hz, then at 5 Hz, with five digits
        ("b2_steps_qs", 0.004, 1.0),
        ("b3_ts_qs_U08_s1", 0.0, 10.0),
        ("b3_ts_qs_U18_s1", 0.01, 10.0),
        ("b3_ts_qs_U12_s1", 0.015, 60.0),
    ],
)
def test_openfast_gives_the_same_commands(
    shared_reference: Path, name: str, pitch_error: float, torque_error: float
) -> None:
    """RMS over the run, of pitch [deg] and torque [N m], given OpenFAST's rotor speed."""
    stored = series(shared_reference / f"{name}.csv.gz")
    times = np.arange(stored["Time"][0], stored["Time"][-1], STEP)
    omega = CubicSpline(stored["Time"], stored["RotSpeed"] * np.pi / 30)(times)
    beta, held = np.radians(stored["BldPitch1"][0]), 1e3 * stored["GenTq"][0]
    controller = nrel_5mw_baseline()
    controller.start(STEP, measured(rotor_speed=float(omega[0]), pitch=beta, generator_torque=held))
    commands = np.array([controller.command(measured(rotor_speed=float(w))) for w in omega])
    late = stored["Time"] > stored["Time"][0] + 20.0
    for index, column, unit, allowed in (
        (s.PITCH_COMMAND, "BldPitch1", np.pi / 180, pitch_error),
        (s.TORQUE, "GenTq", 1e3, torque_error),
    ):
        ours = np.interp(stored["Time"], times, commands[:, index])[late]
        error = ours - unit * stored[column][late]
        scale = np.pi / 180 if index == s.PITCH_COMMAND else 1.0
        assert np.sqrt(np.mean(error**2)) <= allowed * scale
