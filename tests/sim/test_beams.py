"""Beam modes against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.sim.beams import Beam

LENGTH, MASS, STIFFNESS = 40.0, 300.0, 2.0e9
SCALE = np.sqrt(STIFFNESS / (MASS * LENGTH**4))


def uniform(stations: int = 21) -> Beam:
    station = np.linspace(0.0, LENGTH, stations)
    return Beam(
        station,
        np.full(stations, MASS),
        np.broadcast_to(STIFFNESS * np.eye(2), (stations, 2, 2)),
    )


def test_uniform_cantilever() -> None:
    beam = uniform()
    frequency, _ = beam.modes(beam.assemble(beam.mass, 0), beam.assemble(beam.stiffness, 2), 6)
    exact = np.repeat([1.8751040687, 4.6940911330, 7.8547574382], 2) ** 2 * SCALE
    assert frequency == pytest.approx(exact, rel=2e-5)


def test_rotating_uniform_blade() -> None:
    """Southwell: omega^2 = omega_0^2 + 1.193 Omega^2 for the first flap mode without a hub."""
    beam = uniform()
    inertia, elastic = beam.assemble(beam.mass, 0), beam.assemble(beam.stiffness, 2)
    tension = beam.assemble(beam.beyond(beam.mass * beam.points), 1)
    at_rest = beam.modes(inertia, elastic, 1)[0][0]
    slow = 0.05 * at_rest
    turning = beam.modes(inertia, elastic + slow**2 * tension, 1)[0][0]
    assert (turning**2 - at_rest**2) / slow**2 == pytest.approx(1.1934, rel=1e-3)


def test_column_buckles_under_its_own_weight() -> None:
    """A column of weight w per length buckles where w L^3 / EI = 7.837."""
    beam = uniform()
    inertia, elastic = beam.assemble(beam.mass, 0), beam.assemble(beam.stiffness, 2)
    weight = beam.assemble(beam.beyond(np.ones_like(beam.points)), 1)
    critical = 7.8373 * STIFFNESS / LENGTH**3
    assert beam.modes(inertia, elastic - 0.999 * critical * weight, 1)[0][0] < 0.05 * SCALE * 3.5
    with pytest.raises(InputError, match="not stable under its axial load"):
        beam.modes(inertia, elastic - 1.001 * critical * weight, 1)


def test_beyond_is_the_integral_to_the_tip() -> None:
    beam = uniform()
    z = beam.points
    assert beam.beyond(z**2) == pytest.approx((LENGTH**3 - z**3) / 3, rel=1e-12, abs=1e-9)


def test_coupled_bending_follows_the_principal_axes() -> None:
    """Turned principal axes change no frequency, and the modes bend along them."""
    angle, stations = 0.3, 15
    first, second = (
        np.array([np.cos(angle), -np.sin(angle)]),
        np.array([np.sin(angle), np.cos(angle)]),
    )
    stiffness = STIFFNESS * (np.outer(first, first) + 4.0 * np.outer(second, second))
    beam = Beam(
        np.linspace(0.0, LENGTH, stations),
        np.full(stations, MASS),
        np.broadcast_to(stiffness, (stations, 2, 2)),
    )
    frequency, shapes = beam.modes(beam.assemble(beam.mass, 0), beam.assemble(beam.stiffness, 2), 2)
    assert frequency == pytest.approx([3.51602 * SCALE, 2 * 3.51602 * SCALE], rel=1e-4)
    tips = shapes[:, -4::2]
    assert tips[0] / np.linalg.norm(tips[0]) == pytest.approx(first, abs=1e-9)
    assert tips[1] / np.linalg.norm(tips[1]) == pytest.approx(second, abs=1e-9)


def test_bad_stations() -> None:
    with pytest.raises(InputError, match="ascending stations from 0"):
        Beam(np.array([1.0, 2.0, 3.0]), np.ones(3), np.broadcast_to(np.eye(2), (3, 2, 2)))


def test_short_elements_do_not_spoil_the_modes() -> None:
    """A uniform cantilever with elements a two-thousandth of its length, as at a tower's welds."""
    length, mass, stiffness = 100.0, 5000.0, 5e11
    joints = np.arange(1, 20) * 5.0
    station = np.sort(np.concatenate([[0.0, length], joints - 0.025, joints + 0.025]))
    ones = np.ones(station.size)
    beam = Beam(station, mass * ones, stiffness * ones[:, None, None] * np.eye(2))
    modes, _ = beam.modes(beam.assemble(beam.mass, 0), beam.assemble(beam.stiffness, 2), 4)
    for k, root in ((0, 1.8751040687), (2, 4.6940911330)):
        exact = (root / length) ** 2 * np.sqrt(stiffness / mass)
        assert modes[k : k + 2] == pytest.approx(np.full(2, exact), rel=2e-5)
