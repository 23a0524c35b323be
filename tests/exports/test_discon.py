"""Lines of DISCON.IN: found as ROSCO finds them, changed in place, comments that mislead nobody."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.control import IndividualPitch
from pitchopt.errors import InputError
from pitchopt.exports import (
    ActuatorLag,
    changed_discon,
    discon_ipc,
    discon_numbers,
    discon_value,
    open_loop,
    open_loop_discon,
    open_loop_lines,
    read_discon,
)
from pitchopt.exports.discon import DisconLine

TEXT = """\
! a file
!------- FLAGS -------
0                   ! OL_Mode         - open loop
"unused"            ! OL_Filename     - its file
0    0    0         ! Ind_BldPitch    - columns
1.0d-2, 2           ! PAIR
"""
ALL = (
    "PC_ControlMode", "IPC_ControlMode", "OL_Mode", "AWC_Mode", "PA_Mode", "OL_Filename",
    "OL_BP_Mode", "Ind_Breakpoint", "Ind_BldPitch", "Ind_GenTq", "Ind_YawRate", "Ind_Azimuth",
    "PA_CornerFreq", "PA_Damping", "IPC_Vramp", "IPC_SatMode", "IPC_IntSat", "IPC_KP", "IPC_KI",
    "IPC_aziOffset", "IPC_CornerFreqAct", "PC_MinPit", "PC_MaxPit", "PC_MaxRat", "PC_MinRat",
    "Y_ControlMode", "Flp_Mode", "LoggingLevel", "RP_Gains", "Ext_Mode", "ZMQ_Mode",
)  # fmt: skip


def texts():
    controller = IndividualPitch(
        gain=np.array([-1e-8, 2e-9]), offset=[0.3, 0.1], order=[1, 2], fade_to=0.1, fade_time=30.0
    )
    psi = 2 * np.pi * np.arange(24) / 24
    loops = [
        open_loop(psi, 0.1 + 0.01 * np.cos(psi), rotor_speed=1.2, revolutions=2, lag=lag)
        for lag in (None, ActuatorLag(time_constant=0.3), ActuatorLag(frequency=6.0, damping=0.7))
    ]
    section = discon_ipc(controller, only_1p=True, wind_ramp=(9.0, 11.0))
    return [section.text(), *(open_loop_discon(loop) for loop in loops)]


@pytest.mark.parametrize("text", texts(), ids=["ipc", "table", "first order", "second order"])
def test_no_comment_is_taken_for_a_parameter(text, parsed):
    for line in text.splitlines():
        if not line.startswith("!"):
            continue
        for name in ALL:
            for count in range(1, 5):
                assert parsed(line, name, count) is None, line


def test_values_as_rosco_finds_them(parsed):
    assert discon_value(TEXT, "ol_mode") == "0" == parsed(TEXT, "OL_Mode", 1)[0]
    assert discon_value(TEXT, "OL_Filename") == "unused" == parsed(TEXT, "OL_Filename", 1)[0]
    assert discon_numbers(TEXT, "PAIR", 2).tolist() == [0.01, 2.0]
    assert discon_numbers(TEXT, "Ind_BldPitch", 3).tolist() == [0.0, 0.0, 0.0]
    assert discon_value(TEXT, "FLAGS") is None
    assert discon_numbers(TEXT, "nothing", 1) is None


def test_changed_lines_and_all_else_as_it_was(parsed):
    lines = [
        DisconLine(name="OL_Mode", value="1", comment="new"),
        DisconLine(name="Ind_BldPitch", value="2 3 4"),
    ]
    changed = changed_discon(TEXT, lines)
    assert parsed(changed, "OL_Mode", 1) == ["1"]
    assert parsed(changed, "Ind_BldPitch", 3) == ["2", "3", "4"]
    assert "! OL_Mode         - open loop" in changed
    before, after = TEXT.splitlines(), changed.splitlines()
    assert [k for k in range(len(before)) if before[k] != after[k]] == [2, 4]
    again = changed_discon(changed, lines)
    assert again == changed


def test_a_whole_file_gets_every_line_of_an_export(parsed, law):
    base = law.DISCON
    psi = 2 * np.pi * np.arange(24) / 24
    loop = open_loop(psi, 0.1 + 0.01 * np.cos(psi), rotor_speed=1.2,
                     lag=ActuatorLag(frequency=6.0, damping=0.7))  # fmt: skip
    changed = changed_discon(base, open_loop_lines(loop))
    assert parsed(changed, "OL_Filename", 1) == ["pitch_open_loop.dat"]
    assert parsed(changed, "PA_Mode", 1) == ["2"]
    assert parsed(changed, "PA_CornerFreq", 1) == ["6"]
    assert parsed(changed, "PC_KP", 1) == parsed(base, "PC_KP", 1)


def test_missing_and_double_parameters_are_named():
    with pytest.raises(InputError, match=r"has no IPC_KI, IPC_KP, expected a file for ROSCO 2\.9"):
        changed_discon(TEXT, [DisconLine(name="IPC_KI", value="0 0"),
                              DisconLine(name="OL_Mode", value="1"),
                              DisconLine(name="IPC_KP", value="0 0")])  # fmt: skip
    with pytest.raises(InputError, match=r"has OL_Mode in lines 3, 7, expected it once"):
        changed_discon(TEXT + "1 ! OL_Mode\n", [DisconLine(name="OL_Mode", value="1")])


@pytest.mark.parametrize(("name", "count"), [("OL_Filename", 1), ("OL_Mode", 2), ("PAIR", 3)])
def test_numbers_that_are_none(name, count):
    with pytest.raises(InputError, match=rf"^{name}: got .*, expected {count} numbers"):
        discon_numbers(TEXT, name, count)


def test_other_files_are_refused(tmp_path):
    file = tmp_path / "x.IN"
    with pytest.raises(InputError, match=r"DISCON file: got .* \(no such file\)"):
        read_discon(file)
    file.write_text("some words\n! a comment\n")
    with pytest.raises(InputError, match=r"no line of the form 'value ! name'"):
        read_discon(file)
    file.write_text(TEXT)
    assert read_discon(file) == TEXT
