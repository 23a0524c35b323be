"""ROSCO's open-loop table: what stands in it, read as ROSCO reads it, limits, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.exports import (
    ActuatorLag,
    check_open_loop,
    harmonics,
    led_command,
    open_loop,
    open_loop_file,
    read_open_loop,
    truncated,
)
from pitchopt.exports.rosco_open_loop import OpenLoop, check_discon_limits, openfast_notes

OMEGA = 12.1 * np.pi / 30
LAGS = [
    ActuatorLag(time_constant=0.4),
    ActuatorLag(frequency=6.0, damping=0.8, amplitude=False),
]


def turn(count):
    return 2 * np.pi * np.arange(count) / count


@pytest.fixture
def profile():
    return np.random.default_rng(3).normal(0.1, 0.01, 72)


def as_rosco(text, count=4):
    """Numbers of a table as ROSCO reads them: leading comments, then so many a row."""
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if not set("!#%") & set(line))
    return np.array([[float(word) for word in line.split()[:count]] for line in lines[first:]])


@pytest.mark.parametrize("start", [0.0, 0.7, np.deg2rad(10.0), -0.3, 7.0])
def test_blades_follow_the_profile_at_their_azimuth(profile, start):
    loop = open_loop(
        turn(72), profile, rotor_speed=OMEGA, revolutions=3, initial_azimuth=start
    )  # fmt: skip
    table = as_rosco(open_loop_file(loop))
    time = np.linspace(0.0, 3 * 2 * np.pi / OMEGA, 5001)
    for b in range(3):
        place = start + OMEGA * time + 2 * np.pi * b / 3
        wanted = np.interp(place, turn(72), profile, period=2 * np.pi)
        assert np.interp(time, table[:, 0], table[:, b + 1]) == pytest.approx(wanted, abs=1e-13)
    assert table[0, 0] == 0.0
    assert table[-1, 0] >= 3 * 2 * np.pi / OMEGA * (1 - 1e-12)


def test_steps_of_time(profile):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1, step=OMEGA * 0.0125)
    assert np.diff(loop.time) == pytest.approx(0.0125)


@pytest.mark.parametrize("lag", [None, *LAGS], ids=["none", "first", "second"])
@pytest.mark.parametrize("start", [0.0, 0.7])
def test_round_trip(profile, lag, start, tmp_path):
    loop = open_loop(
        turn(72), profile, rotor_speed=OMEGA, revolutions=2, initial_azimuth=start, lag=lag
    )
    file = tmp_path / "t.dat"
    file.write_text(open_loop_file(loop, label="mu = 3,\nrotor_speed_rpm = 99"))
    back = read_open_loop(file)
    assert back.pitch == pytest.approx(loop.pitch, rel=1e-14)
    assert back.time == pytest.approx(loop.time, rel=1e-14)
    assert (back.rotor_speed, back.initial_azimuth) == pytest.approx((OMEGA, start))
    assert back.lag == lag
    azimuth, pitch = back.profile(72)
    assert azimuth == pytest.approx(turn(72))
    if lag is None:
        assert pitch == pytest.approx(profile, abs=1e-13)
    else:
        led = led_command(harmonics(turn(72), profile), lag, OMEGA)
        travel = np.ptp(led(turn(720)))
        assert pitch == pytest.approx(led(turn(72)), abs=0.01 * travel)


def test_a_file_without_header_needs_the_speed(profile, tmp_path):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=2)
    rows = [line for line in open_loop_file(loop).splitlines() if "!" not in line]
    file = tmp_path / "t.dat"
    file.write_text("\n".join(rows))
    with pytest.raises(InputError, match=r"^rotor_speed: .* says none in its header"):
        read_open_loop(file)
    back = read_open_loop(file, rotor_speed=OMEGA)
    assert back.profile(72)[1] == pytest.approx(profile, abs=1e-13)


def test_led_table_is_the_led_series(profile):
    loop = open_loop(
        turn(72), profile, rotor_speed=OMEGA, revolutions=1, lag=LAGS[0], keep_harmonics=4
    )
    led = led_command(truncated(harmonics(turn(72), profile), 4), LAGS[0], OMEGA)
    for b in range(3):
        place = OMEGA * loop.time + 2 * np.pi * b / 3
        assert loop.pitch[b] == pytest.approx(led(place), abs=1e-13)


def test_rows_that_are_enough_for_a_series(profile):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1, keep_harmonics=6)
    series = truncated(harmonics(turn(72), profile), 6)
    time = np.linspace(0.0, 2 * np.pi / OMEGA, 20001)
    chords = np.interp(time, loop.time, loop.pitch[0]) - series(OMEGA * time)
    # (h/2)^2/2 of the highest harmonic at 24 rows a period
    assert np.abs(chords).max() < (2 * np.pi / 24) ** 2 / 8 * series.amplitude[1:].sum()


def test_header_is_comment_to_rosco_and_no_row_is(profile):
    text = open_loop_file(open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1))
    lines = text.splitlines()
    comments = [bool(set("!#%") & set(line)) for line in lines]
    assert comments == sorted(comments, reverse=True)
    assert lines[comments.index(False) - 1].split() == ["!", "(s)", "(rad)", "(rad)", "(rad)"]
    assert as_rosco(text).shape == (73, 4)


def test_notes_say_what_the_simulation_needs(profile):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, initial_azimuth=np.deg2rad(30.0))
    notes = " ".join(openfast_notes(loop))
    at = [np.interp(30.0 + 120.0 * b, np.rad2deg(turn(72)), profile, period=360.0)
          for b in range(3)]  # fmt: skip
    pitch = ", ".join(f"{np.rad2deg(angle):.6g}" for angle in at)
    for part in ("GenDOF False", "RotSpeed 12.1 rpm", "Azimuth 30 deg", f"BlPitch {pitch} deg",
                 "Ptch_Cntrl 1"):  # fmt: skip
        assert part in notes


def test_limits(profile):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1)
    low, high = profile.min(), profile.max()
    fastest = np.abs(np.diff(np.append(profile, profile[0]))).max() * 72 / (2 * np.pi) * OMEGA
    assert loop.rate == pytest.approx(fastest)
    check_open_loop(loop, lowest=low, highest=high, rate=fastest)
    with pytest.raises(InputError, match=rf"^command: needs {math.degrees(fastest):.4g} deg/s"):
        check_open_loop(loop, lowest=low, highest=high, rate=0.99 * fastest)
    with pytest.raises(InputError, match=r"^command: needs .* the range is"):
        check_open_loop(loop, lowest=low + 1e-3)
    with pytest.raises(InputError, match=r"the range is .*; and .* the largest rate is"):
        check_open_loop(loop, highest=high - 1e-3, rate=0.9 * fastest)


def test_limits_of_a_led_command_name_the_harmonics_that_go(profile):
    series = harmonics(turn(72), profile)
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1, lag=LAGS[0])
    with pytest.raises(InputError) as error:
        check_open_loop(loop, rate=0.1, series=series)
    count = int(str(error.value).rpartition("--keep-harmonics ")[2].rstrip(")"))
    for kept, good in ((count, True), (count + 1, False)):
        cut = open_loop(
            turn(72), profile, rotor_speed=OMEGA, revolutions=1, lag=LAGS[0], keep_harmonics=kept
        )
        assert (cut.rate <= 0.1 * (1 + 1e-6)) is good
    with pytest.raises(InputError, match="not even the first harmonic"):
        check_open_loop(loop, rate=1e-6, series=series)


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("0.09 ! PC_MinPit", "PC_MinPit"),
        ("0.11 ! PC_MaxPit", "PC_MaxPit"),
        ("0.1 ! PC_MaxRat", "PC_MaxRat"),
        ("-0.1 ! PC_MinRat", "PC_MinRat"),
    ],
)
def test_limits_of_a_parameter_file(profile, line, name):
    loop = open_loop(turn(72), profile, rotor_speed=OMEGA, revolutions=1)
    check_discon_limits(loop, "0.0 ! PC_MinPit\n1.5 ! PC_MaxPit\n9 ! PC_MaxRat\n-9 ! PC_MinRat\n")
    with pytest.raises(InputError, match=rf"^{name}: the DISCON file has"):
        check_discon_limits(loop, line)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"rotor_speed": 0.0}, "rotor_speed"),
        ({"revolutions": 0}, "revolutions"),
        ({"step": 0.0}, "step"),
        ({"initial_azimuth": np.nan}, "initial_azimuth"),
        ({"interpolation": "cubic"}, "interpolation"),
        ({"keep_harmonics": 99}, "keep_harmonics"),
        ({"profile": np.zeros(5)}, "profile"),
    ],
)
def test_bad_arguments(profile, change, field):
    given = {"rotor_speed": OMEGA, "profile": profile, **change}
    with pytest.raises(InputError, match=f"^{field}"):
        open_loop(turn(72), given.pop("profile"), **given)


@pytest.mark.parametrize(
    "text",
    ["! only a header\n", "0 1 2 3\n", "! rotor_speed_rpm = 12\n0 1 2\n1 1 2\n",
     "! rotor_speed_rpm = 12\n0 1 2 3\n0 1 2 3\n", "! rotor_speed_rpm = x\n0 1 2 3\n1 1 2 3\n",
     "! rotor_speed_rpm = 12\n0 a 2 3\n", "! rotor_speed_rpm = 12\n0 1 2 3\n1 nan 2 3\n"],
)  # fmt: skip
def test_bad_files(tmp_path, text):
    file = tmp_path / "t.dat"
    file.write_text(text)
    with pytest.raises(InputError, match=r"open-loop file|rotor_speed"):
        read_open_loop(file)


def test_too_short_a_table_has_no_profile():
    loop = OpenLoop(time=[0.0, 1.0], pitch=np.zeros((3, 2)), rotor_speed=1.0)
    with pytest.raises(InputError, match=r"covers 0\.159 revolutions"):
        loop.profile(12)
