"""Natural frequencies of the whole turbine against the NREL 5 MW report, and whirl."""

from __future__ import annotations

import math

import pytest

from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, natural_modes

TURN = 2.0 * math.pi


def by_label(modes) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for mode in modes:
        found.setdefault(mode.label, []).append(mode.frequency / TURN)
    return found


def test_report_of_the_nrel_5mw(nrel) -> None:
    """NREL/TP-500-38060, table 9-1, FAST, standing rotor."""
    modes = by_label(natural_modes(DynamicTurbine(turbine=nrel), 0.0))
    assert modes["tower fore-aft"][0] == pytest.approx(0.3240, rel=0.035)
    assert modes["tower side-side"][0] == pytest.approx(0.3120, rel=0.035)
    assert modes["flap collective"][0] == pytest.approx(0.6993, rel=0.01)
    assert modes["flap cosine"][0] == pytest.approx(0.6675, rel=0.03)
    assert modes["flap sine"][0] == pytest.approx(0.6664, rel=0.03)
    assert modes["edge sine"][0] == pytest.approx(1.0793, rel=0.02)
    assert modes["edge cosine"][0] == pytest.approx(1.0898, rel=0.02)


def test_drivetrain_torsion(nrel) -> None:
    """Report: 0.6205 Hz with the generator held; free-free, shaft and collective edge couple."""
    dynamic = DynamicTurbine(turbine=nrel, freedoms=["rotor-speed", "shaft-torsion"])
    (mode,) = natural_modes(dynamic, 0.0)
    rotor = nrel.rotor_inertia
    generator = 534.116 * 97.0**2
    exact = math.sqrt(867.637e6 * (1.0 / rotor + 1.0 / generator)) / TURN
    assert mode.frequency / TURN == pytest.approx(exact, rel=0.005)
    ratio = 6.215e6 / 867.637e6 * exact * TURN / 2.0
    assert mode.damping == pytest.approx(ratio, rel=0.01)


def test_whirl_splits_by_twice_the_rotor_speed(nrel) -> None:
    """A blade mode of frequency f in the rotor stands at f - Omega and f + Omega outside it."""
    dynamic = DynamicTurbine(turbine=nrel, freedoms=["blade-edge"])
    speed = 1.2671
    modes = [m.frequency for m in natural_modes(dynamic, speed)]
    assert len(modes) == 3
    assert modes[2] - modes[0] == pytest.approx(2.0 * speed, rel=1e-3)
    assert modes[1] == pytest.approx(0.5 * (modes[0] + modes[2]), rel=1e-3)


def test_centrifugal_stiffening(nrel) -> None:
    """Flap frequency rises with rotor speed by a Southwell coefficient of 1 to 2."""
    dynamic = DynamicTurbine(turbine=nrel, freedoms=["blade-flap"])
    low, high = (
        sorted(m.frequency for m in natural_modes(dynamic, speed))[1] for speed in (0.0, 2.0)
    )
    assert 1.0 < (high**2 - low**2) / 4.0 < 2.0


def test_bad_rotor_speed(nrel) -> None:
    with pytest.raises(InputError, match="rotor_speed: got -1"):
        natural_modes(DynamicTurbine(turbine=nrel), -1.0)
