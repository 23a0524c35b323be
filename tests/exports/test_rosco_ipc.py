"""Individual pitch in ROSCO's parameters: its law beside our kernel, round trip, what it lacks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pitchopt.control import IndividualPitch, to_fixed_frame
from pitchopt.errors import InputError
from pitchopt.exports import discon_ipc, read_discon_ipc
from pitchopt.exports.rosco_ipc import check_discon_modes

SPEED, STEP = 12.1 * math.pi / 30, 0.0125


@pytest.fixture
def numbers(parsed):
    """Numbers of a parameter in a section, as ROSCO finds them."""

    def found(section, name, count=1):
        words = parsed(section.text(), name, count)
        assert words is not None
        return [float(word) for word in words]

    return found


def rosco_pitch(law, numbers, section, measured, time, *, corrected=False):
    """What ROSCO's law adds with these parameters, for measured moments (T, 3)."""
    return law.individual_pitch_law(
        law.band_pass(measured, rotor_speed=SPEED, step=STEP, corrected=corrected),
        SPEED * time,
        step=STEP,
        gain=tuple(numbers(section, "IPC_KI", 2)),
        offset=tuple(numbers(section, "IPC_aziOffset", 2)),
        limit=numbers(section, "IPC_IntSat")[0],
    )


@pytest.fixture(scope="module")
def signal(bench):
    assert (bench.SPEED, bench.STEP) == (SPEED, STEP)
    time = STEP * np.arange(4000)
    rough = 2e5 * np.random.default_rng(1).normal(size=(time.size, 3))
    return time, bench.moments(time, second=1e5) + rough


@pytest.mark.parametrize("gain", [2e-9, -2e-9])
@pytest.mark.parametrize("offset", [0.0, 0.35, -1.2, 3.0])
def test_law_and_kernel_agree_to_rounding(signal, law, bench, numbers, gain, offset):
    time, measured = signal
    controller = IndividualPitch(gain=np.array([gain]), offset=[offset], limit=0.3)
    section = discon_ipc(controller, filter_gain=1.0)
    passed = law.band_pass(measured, rotor_speed=SPEED, step=STEP)
    theirs = law.individual_pitch_law(
        passed, SPEED * time, step=STEP, gain=tuple(numbers(section, "IPC_KI", 2)),
        offset=tuple(numbers(section, "IPC_aziOffset", 2)), limit=0.3,
    )  # fmt: skip
    ours = bench.ours(controller, time, passed)
    assert np.abs(ours).max() > 0.01
    assert np.abs(theirs - ours).max() < 1e-12


def test_the_band_pass_is_what_the_factor_says(law, bench):
    # the discrete filter on a sine, after its start, against the formula
    time = STEP * np.arange(8000)
    for order, corrected, size in (
        (1, False, 0.5), (1, True, 1.0), (2, False, 0.345), (2, True, 0.690),
    ):  # fmt: skip
        wave = np.exp(1j * order * SPEED * time)
        passed = law.band_pass(
            np.stack([wave.real, wave.imag], axis=1), rotor_speed=SPEED, step=STEP,
            corrected=corrected,
        )  # fmt: skip
        answer = (passed[-1, 0] + 1j * passed[-1, 1]) / wave[-1]
        assert answer == pytest.approx(bench.response(order, corrected=corrected), abs=1e-6)
        assert abs(answer) == pytest.approx(size, rel=2e-3)
    assert math.degrees(np.angle(bench.response(2, corrected=True))) == pytest.approx(
        -46.4, abs=0.1
    )


@pytest.mark.parametrize("corrected", [False, True])
def test_written_gain_integrates_as_ours_behind_the_band_pass(law, bench, numbers, corrected):
    time = STEP * np.arange(8000)
    measured = bench.moments(time)
    controller = IndividualPitch(gain=np.array([3e-10]), offset=[0.35])
    share = 1.0 if corrected else 0.5
    section = discon_ipc(controller, filter_gain=share)
    theirs = rosco_pitch(law, numbers, section, measured, time, corrected=corrected)
    ours = bench.ours(controller, time, measured)
    mine, other = (bench.growth(pitch, time, 1, 0.35) for pitch in (ours, theirs))
    # the filter's half step of phase and what the fixed frame changes within its lag of 1.1 s
    assert np.linalg.norm(other - mine) < 0.02 * np.linalg.norm(mine)


def test_factor_of_the_transform_and_signs_are_ours(law):
    # tilt and yaw with 2/3, blade b at 2 pi (b-1)/3, as the law has it
    psi = np.array([0.3, 2.0])
    moments = np.random.default_rng(0).normal(size=(2, 3))
    added = law.individual_pitch_law(
        moments, psi, step=1.0, gain=(1.0, 0.0), offset=(0.0, 0.0), limit=9.0
    )
    part = to_fixed_frame(moments[1], psi[1])
    blades = psi[1] + 2 * np.pi / 3 * np.arange(3)
    assert added[1] == pytest.approx(part[0] * np.cos(blades) + part[1] * np.sin(blades))


@pytest.mark.parametrize("gain", [1.3e-8, -1.3e-8])
def test_round_trip(gain, tmp_path, numbers):
    controller = IndividualPitch(gain=np.array([gain]), offset=[0.35], limit=0.07)
    file = tmp_path / "DISCON.IN"
    for share in (0.5, 1.0):
        section = discon_ipc(controller, filter_gain=share)
        assert numbers(section, "IPC_KI", 2) == pytest.approx([abs(gain) / share, 0.0])
        file.write_text(section.text())
        back = read_discon_ipc(file, filter_gain=share)
        assert back.limit == pytest.approx([0.07])
        # gain and offset may both be turned; their product on the two parts is the same
        for one in (np.cos, np.sin):
            assert back.gain * one(back.offset) == pytest.approx(gain * one(np.array([0.35])))
    assert back.gain[0] > 0.0  # ROSCO refuses negative ones


def test_what_rosco_lacks_is_refused_or_named(numbers):
    both = IndividualPitch(gain=np.array([2e-8, 1e-8]), offset=[0.1, 0.2])
    with pytest.raises(InputError, match=r"^harmonics: got 1P, 2P, expected 1P alone"):
        discon_ipc(both)
    section = discon_ipc(both, only_1p=True)
    assert any("left out: 2P, gain 1e-08" in note for note in section.lacks)
    assert numbers(section, "IPC_ControlMode") == [1.0]
    assert numbers(section, "IPC_KI", 2)[1] == 0.0
    with pytest.raises(InputError, match=r"^harmonics: got 2P, expected 1P"):
        discon_ipc(IndividualPitch(gain=np.array([1e-8]), order=[2]), only_1p=True)

    fading = IndividualPitch(gain=np.array([2e-8]), fade_from=0.0, fade_to=0.1, fade_time=20.0)
    with pytest.raises(InputError, match=r"^wind_ramp: got none, but the controller fades"):
        discon_ipc(fading)
    section = discon_ipc(fading, wind_ramp=(9.0, 11.0))
    assert numbers(section, "IPC_Vramp", 2) == [9.0, 11.0]
    for part in ("left out: fade from 0 to 5.72958 deg", "left out: fade over the first 20 s"):
        assert any(part in note for note in section.lacks)


def test_individual_pitch_that_does_nothing_is_refused():
    with pytest.raises(InputError, match=r"^gain: got 0 at 1P"):
        discon_ipc(IndividualPitch(gain=np.array([0.0, 1e-8])), only_1p=True)


def test_a_second_harmonic_without_gain_is_no_obstacle():
    discon_ipc(IndividualPitch(gain=np.array([2e-8, 0.0])))


def test_without_ramp_the_gains_are_full_everywhere(numbers):
    low, high = numbers(discon_ipc(IndividualPitch(gain=np.array([1e-8]))), "IPC_Vramp", 2)
    assert 0.0 <= low < high <= 1.0  # equal speeds would divide by zero in ROSCO


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"wind_ramp": (11.0, 9.0)}, "wind_ramp"),
        ({"wind_ramp": (9.0, 9.0)}, "wind_ramp"),
        ({"wind_ramp": (9.0,)}, "wind_ramp"),
        ({"filter_gain": 0.0}, "filter_gain"),
        ({"filter_gain": np.nan}, "filter_gain"),
    ],
)
def test_bad_arguments(given, field):
    with pytest.raises(InputError, match=f"^{field}"):
        discon_ipc(IndividualPitch(gain=np.array([1e-8])), **given)


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("IPC_ControlMode", "0 ! IPC_ControlMode", "IPC_ControlMode"),
        ("IPC_ControlMode", "2 ! IPC_ControlMode", "IPC_ControlMode"),
        ("IPC_KP", "1e-8 0 ! IPC_KP", "IPC_KP"),
        ("IPC_CornerFreqAct", "3 ! IPC_CornerFreqAct", "IPC_CornerFreqAct"),
        ("IPC_Vramp", "9 11 ! IPC_Vramp", "IPC_Vramp"),
        ("IPC_KI", "x y ! IPC_KI", "IPC_KI"),
        ("IPC_KI", "", "DISCON file"),
        ("IPC_IntSat", "0 ! IPC_IntSat", "limit"),
    ],
)
def test_files_that_ours_cannot_be(old, new, field, tmp_path):
    text = discon_ipc(IndividualPitch(gain=np.array([1e-8]))).text()
    rows = [new if f"! {old}" in line else line for line in text.splitlines()]
    file = tmp_path / "DISCON.IN"
    file.write_text("\n".join(rows))
    with pytest.raises(InputError, match=f"^{field}"):
        read_discon_ipc(file)


def test_a_ramp_may_be_dropped(tmp_path):
    file = tmp_path / "DISCON.IN"
    file.write_text(discon_ipc(IndividualPitch(gain=np.array([1e-8])), wind_ramp=(9, 11)).text())
    assert read_discon_ipc(file, drop_ramp=True).gain == pytest.approx([1e-8])


@pytest.mark.parametrize(
    ("name", "value"),
    [("PC_ControlMode", "0"), ("Y_ControlMode", "2"), ("Flp_Mode", "1"), ("AWC_Mode", "3")],
)
def test_a_file_with_which_rosco_takes_no_individual_pitch_is_refused(name, value):
    good = "1 ! PC_ControlMode - on\n0 ! Y_ControlMode - off\n0 ! Flp_Mode\n0 ! AWC_Mode\n"
    check_discon_modes(good)
    bad = "\n".join(f"{value} ! {name}" if name in line else line for line in good.splitlines())
    with pytest.raises(InputError, match=f"{name}: the DISCON file has {value}, expected"):
        check_discon_modes(bad)
