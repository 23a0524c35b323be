"""``pitchopt export``: ROSCO, controllers, files of several winds, what does not go together."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from pitchopt.cli import main
from pitchopt.control import IndividualPitch
from pitchopt.exports import (
    ActuatorLag,
    ProfileSet,
    harmonics,
    led_command,
    read_discon_ipc,
    read_harmonics_csv,
    read_open_loop,
    read_profile_csv,
    read_schedule_csv,
    truncated,
)

DISCON = """\
! a file
1       ! PC_ControlMode
0       ! IPC_ControlMode
0       ! OL_Mode
0       ! AWC_Mode
0       ! PA_Mode
-0.5    ! PC_MinPit
1.5     ! PC_MaxPit
0.2     ! PC_MaxRat
-0.2    ! PC_MinRat
0 1     ! IPC_Vramp
2       ! IPC_SatMode
0.3     ! IPC_IntSat
0 0     ! IPC_KP
0 0     ! IPC_KI
0 0     ! IPC_aziOffset
0       ! IPC_CornerFreqAct
"unused" ! OL_Filename
0       ! OL_BP_Mode
0       ! Ind_Breakpoint
0 0 0   ! Ind_BldPitch
0       ! Ind_GenTq
0       ! Ind_YawRate
0       ! Ind_Azimuth
3.14    ! PA_CornerFreq
0.7     ! PA_Damping
"""
CONTROLLER = """\
base = "tuned"
[individual]
harmonics = [1]
gain = [2e-8]
offset_deg = [10]
amplitude_deg = 4
"""
TUNED = {
    "problem": "individual-pitch", "method": "bayes", "turbine": "nrel-5mw",
    "parameters": ["gain_1p", "offset_1p", "gain_2p", "offset_2p"],
    "best": {"x": [2e-8, 0.3, 1e-8, 0.1]}, "settings": {"problem": {"amplitude": 0.08}},
}  # fmt: skip


def left(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """Files of robust and schedule."""
    folder = tmp_path_factory.mktemp("several")
    common = ["--case", "biegel2011", "--mu", "10", "--positions", "6", "--segments", "10",
              "--starts", "1", "--no-certify", "--no-plots"]  # fmt: skip
    for command, winds in (("robust", "--winds"), ("schedule", "--wind-speeds")):
        assert main([command, winds, "13,15", *common, "--out", str(folder)]) == 0
    return folder


def knee(finished):
    held = ProfileSet.load(finished / "profiles.npz")
    return held, held.profiles[held.row("knee")]


def test_open_loop(run, finished, tmp_path):
    (tmp_path / "mine.IN").write_text(DISCON)
    done = run("export", finished / "profiles.npz", "--format", "rosco", "--revolutions", "3",
               "--initial-azimuth-deg", "40", "--discon", "mine.IN", "--out", "r")  # fmt: skip
    assert done.status == 0, done.err
    assert left(tmp_path / "r") == [
        "DISCON_open_loop.IN", "discon_open_loop.txt", "pitch_open_loop.dat",
    ]  # fmt: skip
    held, profile = knee(finished)
    loop = read_open_loop(tmp_path / "r" / "pitch_open_loop.dat")
    assert loop.profile(held.azimuth.size)[1] == pytest.approx(profile)
    assert loop.rotor_speed == pytest.approx(held.rotor_speed)
    assert loop.initial_azimuth == pytest.approx(np.deg2rad(40.0))
    text = (tmp_path / "r" / "DISCON_open_loop.IN").read_text()
    assert '"pitch_open_loop.dat"       ! OL_Filename' in text
    assert "GenDOF False" in done.err and done.out.startswith("mu=")


def test_open_loop_with_time_step_as_json(run, finished, tmp_path):
    done = run("export", finished / "profiles.npz", "--format", "rosco", "--time-step", "0.0125",
               "--revolutions", "1", "--json")  # fmt: skip
    document = json.loads(done.out)
    assert document["files"] == ["pitch_open_loop.dat", "discon_open_loop.txt"]
    assert any("Ptch_Cntrl 1" in note for note in document["notes"])
    assert np.diff(read_open_loop(tmp_path / "pitch_open_loop.dat").time) == pytest.approx(0.0125)


@pytest.mark.parametrize("form", ["rosco", "harmonics", "csv"])
def test_lead(run, finished, tmp_path, form):
    done = run("export", finished / "profiles.npz", "--format", form, "--actuator-lag", "0.2",
               "--keep-harmonics", "3", "--beyond-limits")  # fmt: skip
    assert done.status == 0, done.err
    held, profile = knee(finished)
    series = truncated(harmonics(held.azimuth, profile), 3)
    led = led_command(series, ActuatorLag(time_constant=0.2), held.rotor_speed)
    if form == "rosco":
        loop = read_open_loop(tmp_path / "pitch_open_loop.dat")
        assert loop.pitch[0] == pytest.approx(led(held.rotor_speed * loop.time))
        assert loop.lag == ActuatorLag(time_constant=0.2)
        text = (tmp_path / "discon_open_loop.txt").read_text()
        assert "5                           ! PA_CornerFreq" in text
    elif form == "harmonics":
        assert read_harmonics_csv(tmp_path / "harmonics.csv").sine == pytest.approx(led.sine)
    else:
        assert read_profile_csv(tmp_path / "profile.csv")[1] == pytest.approx(led(held.azimuth))


def test_a_command_beyond_the_limits_is_refused(run, finished, tmp_path):
    wanted = ("export", finished / "profiles.npz", "--format", "rosco", "--actuator-lag", "2")
    done = run(*wanted)
    assert done.status == 2
    assert done.err.startswith("pitchopt: command: needs ")
    assert done.err.count("\n") == 1 and "--beyond-limits" in done.err
    assert left(tmp_path) == []
    done = run(*wanted, "--beyond-limits")
    assert done.status == 0
    assert "beyond the limits: command: needs" in done.err


def test_a_parameter_file_that_cuts_is_refused(run, finished, tmp_path):
    (tmp_path / "mine.IN").write_text(DISCON.replace("-0.5    !", "0.9 !"))
    done = run("export", finished / "profiles.npz", "--format", "rosco", "--discon", "mine.IN")
    assert done.status == 2
    assert "PC_MinPit: the DISCON file has 0.9" in done.err
    assert left(tmp_path) == ["mine.IN"]


@pytest.mark.parametrize(
    ("mode", "options", "told"),
    [
        ("0", (), False),
        ("1", (), True),
        ("1", ("--actuator-lag", "0.25"), False),
        ("1", ("--actuator-lag", "0.1"), True),
        ("2", ("--actuator-lag", "0.25"), True),
        ("2", ("--actuator-frequency", "4", "--actuator-damping", "0.7"), False),
    ],
)
def test_an_actuator_that_gives_way_is_named(run, finished, tmp_path, mode, options, told):
    text = DISCON.replace("0       ! PA_Mode", f"{mode} ! PA_Mode").replace("3.14 ", "4.0 ")
    (tmp_path / "mine.IN").write_text(text)
    done = run("export", finished / "profiles.npz", "--format", "rosco", "--discon", "mine.IN",
               "--keep-harmonics", "1", "--beyond-limits", *options)  # fmt: skip
    assert done.status == 0, done.err
    assert ("replaced: the DISCON file's actuator" in done.err) is told


@pytest.mark.parametrize(("file", "row"), [("robust", 0), ("schedule", 1)])
def test_files_of_several_winds(run, several, tmp_path, file, row):
    point = ("--point", "15 m/s") if file == "schedule" else ()
    done = run("export", several / f"{file}.npz", "--format", "csv", *point)
    assert done.status == 0, done.err
    _, profiles, _ = read_schedule_csv(several / f"{file}.csv")
    assert read_profile_csv(tmp_path / "profile.csv")[1] == pytest.approx(profiles[row])
    assert done.out == ("15 m/s" if point else "all winds") + ": profile.csv\n"
    assert run("export", several / f"{file}.npz", "--format", "aerodyn", *point).status == 0


def test_a_schedule_needs_a_wind(run, several):
    done = run("export", several / "schedule.npz", "--format", "csv")
    assert done.status == 2
    assert "one of 13 m/s, 15 m/s" in done.err


def test_controller_file(run, tmp_path):
    (tmp_path / "c.toml").write_text(CONTROLLER)
    (tmp_path / "mine.IN").write_text(DISCON)
    done = run("export", "c.toml", "--format", "discon", "--discon", "mine.IN", "--out", "d")
    assert done.status == 0, done.err
    assert left(tmp_path / "d") == ["DISCON_ipc.IN", "discon_ipc.txt"]
    for name in left(tmp_path / "d"):
        back = read_discon_ipc(tmp_path / "d" / name)
        assert isinstance(back, IndividualPitch)
        assert (back.gain, back.offset, back.limit) == pytest.approx(
            (2e-8, np.deg2rad(10.0), np.deg2rad(4.0))
        )
    assert "1.41 times" in done.err


def test_other_parts_of_a_controller_are_named(run, tmp_path):
    profile = "[feedforward]\ncosine_deg = [1]\n"
    lowest = "[minimum_pitch]\nwind_speed = [8, 14]\npitch_deg = [0, 1]\n"
    (tmp_path / "c.toml").write_text(CONTROLLER + profile + lowest)
    done = run("export", "c.toml", "--format", "discon")
    assert done.status == 0, done.err
    for part in ("the feed-forward profile", "the lowest pitch over the wind speed"):
        assert f"left out: {part}" in done.err
    assert "torque and speed regulation stay ROSCO's own" in done.err


def test_tuned_controller(run, tmp_path):
    (tmp_path / "tuning.json").write_text(json.dumps(TUNED))
    done = run("export", "tuning.json", "--format", "discon")
    assert done.status == 2
    assert "harmonics: got 1P, 2P, expected 1P alone" in done.err
    assert left(tmp_path) == ["tuning.json"]
    done = run("export", "tuning.json", "--format", "discon", "--only-1p", "--filter-gain", "1")
    assert done.out == "best of bayes on nrel-5mw: discon_ipc.txt\n"
    assert "left out: 2P, gain 1e-08" in done.err
    back = read_discon_ipc(tmp_path / "discon_ipc.txt", filter_gain=1.0)
    assert (back.gain, back.offset, back.limit) == pytest.approx((2e-8, 0.3, 0.08))


def test_named_controller_fades(run, tmp_path):
    done = run("export", "ipc", "--format", "discon")
    assert done.status == 2
    assert "wind_ramp: got none, but the controller fades from 0 to 5 deg" in done.err
    done = run("export", "ipc", "--format", "discon", "--wind-ramp", "9,11", "--pitch-lag", "0.3")
    assert done.status == 0
    back = read_discon_ipc(tmp_path / "discon_ipc.txt", drop_ramp=True)
    assert back.offset == pytest.approx(np.arctan(0.3 * 12.1 * np.pi / 30), rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("p.npz", "--format", "csv", "--revolutions", "3"),
         r"--revolutions: given with --format csv, expected one of aerodyn, rosco"),
        (("p.npz", "--format", "aerodyn", "--actuator-lag", "0.3"),
         r"--actuator-lag: given with --format aerodyn, whose driver prescribes the motion"),
        (("p.npz", "--format", "rosco", "--only-1p"), r"--only-1p: given with --format rosco"),
        (("c.toml", "--format", "discon", "--point", "knee"), r"--point: given with"),
        (("c.toml", "--format", "discon", "--mu", "3"), r"--mu: given together with a controller"),
        (("--format", "discon"), r"controller: got nothing"),
        (("c.toml", "--format", "rosco"), r"profiles file: got 'c.toml', .*--format discon"),
        (("p.npz", "--format", "discon"), r"controller: got 'p.npz', .*--format rosco"),
        (("baseline", "--format", "discon"), r"controller: 'baseline' has no individual pitch"),
        (("ip", "--format", "discon"), r"controller: got 'ip', .*did you mean 'ipc'"),
        (("n.toml", "--format", "discon"), r"controller: n.toml: no such file"),
        (("n.json", "--format", "discon"), r"controller: got 'n.json' \(no such file\)"),
        (("ipc", "--format", "discon", "--wind-ramp", "9"), r"--wind-ramp: got 1 speeds"),
        (("ipc", "--format", "discon", "--wind-ramp", "11,9"), r"--wind-ramp: got 11 to 9 m/s"),
        (("ipc", "--format", "discon", "--turbine", "nrel"), r"nrel"),
        (("ipc", "--format", "discon", "--filter-gain", "0"), r"--filter-gain: got '0'"),
    ],
)  # fmt: skip
def test_what_does_not_go_together(run, tmp_path, arguments, message):
    done = run("export", *arguments)
    assert done.status == 2
    assert done.out == ""
    assert len(done.err.strip().splitlines()) == 1
    assert re.search(message, done.err), done.err
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--phase-only",), "--phase-only: got no actuator"),
        (("--actuator-frequency", "6"), "--actuator-damping: got nothing"),
        (("--actuator-damping", "1"), "--actuator-frequency: got nothing"),
        (("--actuator-lag", "1", "--actuator-frequency", "6", "--actuator-damping", "1"),
         "--actuator-lag: got 1 s beside --actuator-frequency"),
        (("--step-deg", "2", "--time-step", "0.1"), "--time-step: got 0.1 s beside --step-deg"),
        (("--keep-harmonics", "99"), "keep_harmonics: got 99, expected at most"),
        (("--discon", "nothing.IN"), "DISCON file: got 'nothing.IN' (no such file)"),
        (("--time-step", "30"), "step: got"),
    ],
)  # fmt: skip
def test_options_of_the_open_loop(run, finished, tmp_path, options, message):
    done = run("export", finished / "profiles.npz", "--format", "rosco", *options)
    assert done.status == 2
    assert message in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"problem": "torque-gain"}, "tunes 'torque-gain', expected the problem individual-pitch"),
        ({"best": None}, "is no tuning.json of pitchopt tune"),
        ({"parameters": ["gain_1p"]}, "is no tuning.json of pitchopt tune"),
        ({"settings": {}}, "is no tuning.json of pitchopt tune"),
        ({"best": {"x": [0.0, 0.0, 0.0, 0.0]}}, "gain: got 0 at 1P"),
    ],
)
def test_bad_tuning_files(run, tmp_path, change, message):
    (tmp_path / "t.json").write_text(json.dumps({**TUNED, **change}))
    done = run("export", "t.json", "--format", "discon", "--only-1p")
    assert done.status == 2
    assert message in done.err
    (tmp_path / "t.json").write_text("[1, 2")
    assert "is no tuning.json" in run("export", "t.json", "--format", "discon").err


def test_help_has_an_example_of_every_format(run):
    text = run("export", "--help").out
    for form in ("csv", "harmonics", "aerodyn", "rosco", "discon"):
        assert f"--format {form}" in text
        assert f"\n  {form:<10} " in text
