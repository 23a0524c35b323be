"""ROSCO's compiled controller, called over the swap array as OpenFAST does, and its law in numpy.

The library is that of the package ``rosco`` (``pip install --no-deps --target FOLDER rosco``) or
one named by ``PITCHOPT_LIBDISCON``.  A library takes one run a process.  The parameter file is made
here, with no more than what 2.10.6 asks for when estimator, torque and smoothing are off.
"""

from __future__ import annotations

import ctypes
import importlib.util
import multiprocessing
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["DISCON", "band_pass", "find_library", "individual_pitch_law", "run", "version"]

DISCON = """\
! NREL 5 MW, collective pitch held at its start by zero gains
0       ! LoggingLevel
0       ! Echo
0       ! Ext_Interface
1       ! F_LPFType
0       ! VS_ControlMode
0       ! VS_ConstPower
0       ! VS_FBP
1       ! PC_ControlMode
0       ! Y_ControlMode
0       ! SS_Mode
0       ! WE_Mode
0       ! PS_Mode
0       ! IPC_ControlMode
0       ! OL_Mode
0       ! PA_Mode
0       ! AWC_Mode
1.5708  ! F_LPFCornerFreq
0.7     ! F_LPFDamping
0       ! F_NumNotchFilts
0.0     ! F_NotchFreqs
0.0     ! F_NotchBetaNum
0.0     ! F_NotchBetaDen
0       ! F_GenSpdNotch_N
0       ! F_GenSpdNotch_Ind
0       ! F_TwrTopNotch_N
0       ! F_TwrTopNotch_Ind
0.6283  ! F_SSCornerFreq
0.2094  ! F_WECornerFreq
0.1795  ! F_YawErr
0.0 1.0 ! F_FlCornerFreq
0.0104  ! F_FlHighPassFreq
0.0 1.0 ! F_FlpCornerFreq
0.0500  ! F_VSRefSpdCornerFreq
2       ! PC_GS_n
0.0 0.4 ! PC_GS_angles
0.0 0.0 ! PC_GS_KP
0.0 0.0 ! PC_GS_KI
0.0 0.0 ! PC_GS_KD
0.0 0.0 ! PC_GS_TF
1.57    ! PC_MaxPit
-1.0    ! PC_MinPit
100.0   ! PC_MaxRat
-100.0  ! PC_MinRat
122.91  ! PC_RefSpd
-1.0    ! PC_FinePit
0.01745 ! PC_Switch
0.0 1.0 ! IPC_Vramp
0       ! IPC_SatMode
0.3     ! IPC_IntSat
0.0 0.0 ! IPC_KP
0.0 0.0 ! IPC_KI
0.0 0.0 ! IPC_aziOffset
0.0     ! IPC_CornerFreqAct
94.4    ! VS_GenEff
43093.5 ! VS_ArSatTq
1.5e6   ! VS_MaxRat
47402.9 ! VS_MaxTq
0.0     ! VS_MinTq
35.29   ! VS_MinOMSpd
2.1858  ! VS_Rgn2K
5.0e6   ! VS_RtPwr
43093.5 ! VS_RtTq
122.91  ! VS_RefSpd
1       ! VS_n
-657.44 ! VS_KP
-104.51 ! VS_KI
7.5     ! VS_TSRopt
63.0    ! WE_BladeRadius
97.0    ! WE_GearboxRatio
4.37e7  ! WE_Jtot
1.225   ! WE_RhoAir
"unused" ! OL_Filename
0       ! OL_BP_Mode
0.0     ! OL_BP_FiltFreq
0       ! Ind_Breakpoint
0 0 0   ! Ind_BldPitch
0       ! Ind_GenTq
0       ! Ind_YawRate
0       ! Ind_Azimuth
3.14    ! PA_CornerFreq
0.707   ! PA_Damping
"""

_GEAR = 97.0
_WIND = 15.0  # [m/s]


def find_library() -> Path | None:
    """The compiled controller, None if there is none."""
    named = os.environ.get("PITCHOPT_LIBDISCON")
    if named:
        return Path(named)
    spec = importlib.util.find_spec("rosco")
    for place in (spec.submodule_search_locations or []) if spec is not None else []:
        for name in ("libdiscon.so", "libdiscon.dylib", "libdiscon.dll"):
            if (Path(place) / "lib" / name).is_file():
                return Path(place) / "lib" / name
    return None


def band_pass(
    moments: np.ndarray, *, rotor_speed: float, step: float, corrected: bool = False
) -> np.ndarray:
    """Root moments (T, 3) behind the moving band pass at constant rotor speed.

    Bilinear form of omega s/(d s^2 + omega s + d omega^2), d = 0.7, started from the first value;
    in the numerator ROSCO takes the difference to the last value, `corrected` to the one before.
    """
    d, w = 0.7, rotor_speed
    a2 = d * step**2 * w**2 + 2 * step * w + 4 * d
    a1 = 2 * d * step**2 * w**2 - 8 * d
    a0 = d * step**2 * w**2 - 2 * step * w + 4 * d
    out = np.empty_like(moments)
    y1 = y2 = u1 = u2 = moments[0]
    for k, u in enumerate(moments):
        change = u - (u2 if corrected else u1)
        out[k] = y = (2 * step * w * change - a1 * y1 - a0 * y2) / a2
        y2, y1, u2, u1 = y1, y, u1, u
    return out


def individual_pitch_law(
    moments: np.ndarray,
    azimuth: np.ndarray,
    *,
    step: float,
    gain: tuple[float, float],
    offset: tuple[float, float],
    limit: float,
    second: bool = False,
) -> np.ndarray:
    """Pitch (T, 3) that individual pitch control adds, for moments behind the band pass.

    The first call only resets.  `second` adds what acts of 2P: its tilt part.
    """
    blades = azimuth[:, None] + 2 * np.pi / 3 * np.arange(3)
    added = np.zeros_like(moments)
    for n in (1, 2) if second else (1,):
        tilt = 2 / 3 * np.sum(moments * np.cos(n * blades), axis=1)
        yaw = 2 / 3 * np.sum(moments * np.sin(n * blades), axis=1) if n == 1 else 0 * tilt
        parts = np.zeros(2)
        for k in range(1, azimuth.size):
            parts = np.clip(parts + step * gain[n - 1] * np.array([tilt[k], yaw[k]]), -limit, limit)
            angle = n * (blades[k] + offset[n - 1])
            added[k] += parts[0] * np.cos(angle) + parts[1] * np.sin(angle)
    return added


def run(library: Path, folder: Path, discon: str, signals: dict[str, Any]) -> np.ndarray:
    """Commands (T, 3) [rad] for given signals, in a process of its own.

    Parameters
    ----------
    library : Path
    folder : Path
        Where the parameter file is written and the controller runs.
    discon : str
        Text of the parameter file.
    signals : dict
        ``time`` (T,), ``rotor_speed`` (T,), ``azimuth`` (T,), ``moments`` (T, 3) and ``start``
        (3,), the pitch at the first call.  With ``stiffness`` [N m/rad] the moments fall by so
        much times the last command's difference from the start.
    """
    (folder / "DISCON.IN").write_text(discon, encoding="ascii")
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_drive, args=(str(library), str(folder), signals, there))
    process.start()
    there.close()
    try:
        found = here.recv()
    except EOFError as error:
        raise RuntimeError("ROSCO's library ended without an answer") from error
    finally:
        process.join()
    if isinstance(found, str):
        raise RuntimeError(f"ROSCO: {found}")
    return np.asarray(found)


def version(folder: Path) -> str | None:
    """What the library called itself in the last run in a folder."""
    text = (folder / "greeting.txt").read_text(encoding="utf-8", errors="replace")
    found = re.search(r"Running ROSCO-v?([\w.]+)", text)
    return None if found is None else found[1]


def _drive(library: str, folder: str, signals: dict[str, Any], answer: Any) -> None:
    os.chdir(folder)
    os.dup2(os.open("greeting.txt", os.O_WRONLY | os.O_CREAT), 1)
    pointer = ctypes.POINTER
    function = ctypes.CDLL(library).DISCON
    function.argtypes = [pointer(ctypes.c_float), pointer(ctypes.c_int32),
                         ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p]  # fmt: skip
    swap = np.zeros(2000, dtype=np.float32)
    fail, message = ctypes.c_int32(0), ctypes.create_string_buffer(1000)
    name, out = b"DISCON.IN", b"run.out"
    swap[[48, 49, 50, 51]] = 500, len(name), len(out), 500
    swap[27], swap[60], swap[26] = 1, 3, _WIND
    time = np.asarray(signals["time"])
    swap[2] = time[1] - time[0]
    swap[[3, 32, 33]] = signals["start"]
    commands = np.empty((time.size, 3))
    stiffness, last = signals.get("stiffness", 0.0), np.asarray(signals["start"])
    for k in range(time.size):
        swap[0], swap[1] = float(k > 0), time[k]
        swap[20] = signals["rotor_speed"][k]
        swap[19] = _GEAR * swap[20]
        swap[29:32] = signals["moments"][k] - stiffness * (last - signals["start"])
        swap[59] = signals["azimuth"][k]
        function(
            swap.ctypes.data_as(pointer(ctypes.c_float)), ctypes.byref(fail), name, out, message
        )
        if fail.value < 0:
            answer.send(message.value.decode("ascii", "replace") or f"failed at step {k}")
            return
        commands[k] = last = swap[41:44].astype(np.float64)
    answer.send(commands)
