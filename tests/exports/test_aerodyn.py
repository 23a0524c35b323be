"""Motion files: format, timing of the blades, rates."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.exports import blade_motion, motion_files, read_motion_files
from pitchopt.exports.aerodyn import HEADER, driver_block

OMEGA = 12.1 * np.pi / 30


def turn(count: int) -> np.ndarray:
    return 2 * np.pi * np.arange(count) / count


@pytest.fixture
def profile():
    return np.random.default_rng(3).normal(0.1, 0.02, 72)


def test_rows_at_stations_hold_the_profile(profile):
    motion = blade_motion(turn(72), profile, rotor_speed=OMEGA, revolutions=2)
    assert motion.pitch.shape == (3, 145)
    assert motion.time[-1] == pytest.approx(2 * 2 * np.pi / OMEGA)
    twice = np.append(np.tile(profile, 2), profile[0])
    assert motion.pitch[0] == pytest.approx(twice)
    # blade 2 is a third of a turn ahead, blade 3 two thirds
    assert motion.pitch[1] == pytest.approx(
        np.append(np.tile(np.roll(profile, -24), 2), profile[24])
    )
    assert motion.pitch[2, 0] == pytest.approx(profile[48])


def test_linear_rate_is_the_central_difference_at_stations(profile):
    motion = blade_motion(turn(72), profile, rotor_speed=OMEGA, revolutions=1)
    spacing = 2 * np.pi / 72
    expected = OMEGA * (np.roll(profile, -1) - np.roll(profile, 1)) / (2 * spacing)
    assert motion.rate[0, :-1] == pytest.approx(expected)
    assert not motion.acceleration.any()


def test_linear_between_stations_is_the_straight_line(profile):
    motion = blade_motion(turn(72), profile, rotor_speed=OMEGA, step=np.deg2rad(1.25))
    psi = OMEGA * motion.time
    expected = np.interp(psi, turn(72), profile, period=2 * np.pi)
    assert motion.pitch[0] == pytest.approx(expected)
    inside = np.arange(psi.size) % 4 == 2
    slope = np.diff(np.append(profile, profile[0])) / (2 * np.pi / 72)
    assert motion.rate[0, inside] == pytest.approx(OMEGA * np.tile(slope, 4))


def test_fourier_is_the_series_and_its_derivatives():
    psi = turn(36)
    profile = 0.1 + 0.03 * np.cos(psi) + 0.01 * np.sin(2 * psi)
    motion = blade_motion(
        psi, profile, rotor_speed=OMEGA, step=np.deg2rad(3.0), interpolation="fourier"
    )
    at = OMEGA * motion.time + 2 * np.pi / 3
    assert motion.pitch[1] == pytest.approx(0.1 + 0.03 * np.cos(at) + 0.01 * np.sin(2 * at))
    assert motion.rate[1] == pytest.approx(
        OMEGA * (-0.03 * np.sin(at) + 0.02 * np.cos(2 * at)), abs=1e-12
    )
    assert motion.acceleration[1] == pytest.approx(
        OMEGA**2 * (-0.03 * np.cos(at) - 0.04 * np.sin(2 * at)), abs=1e-12
    )


@pytest.mark.parametrize("interpolation", ["linear", "fourier"])
def test_two_blades_from_an_initial_azimuth(profile, interpolation):
    motion = blade_motion(
        turn(72), profile, rotor_speed=OMEGA, blades=2, initial_azimuth=np.deg2rad(30.0),
        interpolation=interpolation,
    )  # fmt: skip
    assert motion.blades == 2
    assert motion.pitch[0, :60] == pytest.approx(profile[6:66])
    assert motion.pitch[1, :30] == pytest.approx(profile[42:72])


def test_files_round_trip(profile, tmp_path):
    motion = blade_motion(turn(72), profile, rotor_speed=OMEGA, interpolation="fourier")
    files = motion_files(motion)
    assert list(files) == ["pitch_b1.csv", "pitch_b2.csv", "pitch_b3.csv"]
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    back = read_motion_files([tmp_path / name for name in files])
    for field in ("time", "pitch", "rate", "acceleration"):
        assert getattr(back, field) == pytest.approx(getattr(motion, field), rel=1e-14)


def test_format_is_that_of_the_driver(profile):
    text = motion_files(blade_motion(turn(72), profile, rotor_speed=OMEGA))["pitch_b1.csv"]
    first, second = text.splitlines()[:2]
    assert first == "time_[s],pitch_[rad],pitch_rate_[rad/s],pitch_acc_[rad/s^2]"
    assert len(second.split(",")) == 4
    assert second.startswith("0.000000000000000e+00,")


def test_header_is_that_of_the_reference(shared_reference):
    assert HEADER in (shared_reference / "README.md").read_text(encoding="utf-8")


def test_driver_block_names_the_files():
    block = driver_block(["a.csv", "b.csv"], OMEGA)
    assert '"b.csv"' in block
    assert "BldMotionFileName(1_2)" in block
    assert any(line.split() == ["12.1", "RotSpeed(1)", "(rpm)"] for line in block.splitlines())


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"rotor_speed": 0.0}, "rotor_speed"),
        ({"step": 0.0}, "step"),
        ({"step": np.nan}, "step"),
        ({"revolutions": 0}, "revolutions"),
        ({"blades": 0}, "blades"),
        ({"step": 1e-6}, "step, revolutions"),
        ({"interpolation": "cubic"}, "interpolation"),
    ],
)
def test_bad_arguments(profile, change, field):
    with pytest.raises(InputError, match=f"^{field}"):
        blade_motion(turn(72), profile, **{"rotor_speed": OMEGA, **change})


@pytest.mark.parametrize("text", ["a,b,c,d\n", "a,b,c,d\n0,1,2\n", "a,b,c,d\n0,x,2,3\n"])
def test_bad_files(tmp_path, text):
    file = tmp_path / "m.csv"
    file.write_text(text)
    with pytest.raises(InputError, match="motion file"):
        read_motion_files([file])
