"""Damage of frozen loads: closed forms, slopes, thickness."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.fatigue import SNCurve, range_spectra
from pitchopt.studies.tower.design import station_joints
from pitchopt.studies.tower.fatigue_loads import (
    BIN_WIDTH,
    MOMENT_BINS,
    FatigueLoads,
    Weld,
    section_modulus,
)

_JOINTS = station_joints(2, 1)
_PLAIN = Weld(
    curve=SNCurve(slope=4.0, reference_range=80e6, reference_cycles=2e6), thickness_exponent=0.0
)


def _cycles(**counts: FloatArray) -> FloatArray:
    out = np.zeros((2, 2, MOMENT_BINS.size))
    for key, values in counts.items():
        out[:, int(key[1:])] = values
    return out


def test_section_modulus_is_that_of_the_ring() -> None:
    d, t = np.array([5.0, 3.0]), np.array([0.04, 0.3])
    outer, inner = d + t, d - t
    exact = np.pi / 32.0 * (outer**4 - inner**4) / outer
    assert section_modulus(d, t) == pytest.approx(exact, rel=1e-12)


def test_one_range_on_one_slope() -> None:
    cycles = _cycles()
    cycles[:, 0, 700] = [3e5, 6e5]
    loads = FatigueLoads(cycles=cycles, weld=_PLAIN)
    d, t = np.array([4.0, 4.0]), np.array([0.03, 0.03])
    damage = loads.damage(_JOINTS, d, t)
    stress = 1.1 * 1.15 * MOMENT_BINS[700] / section_modulus(d, t)
    assert damage.value == pytest.approx(np.array([3e5, 6e5]) / 2e6 * (stress / 80e6) ** 4)
    # W goes with d^2 t but for the outer fibre's t / 2
    assert damage.by_diameter == pytest.approx(-8.0 - 4.0 * 0.03 / 4.03, abs=2e-3)
    assert damage.by_thickness == pytest.approx(-4.0 + 4.0 * 0.03 / 4.03, abs=2e-3)


def test_worst_axis_counts() -> None:
    cycles = _cycles()
    cycles[0, 0, 650], cycles[0, 1, 700] = 1e6, 1e6
    cycles[1, 0, 700], cycles[1, 1, 650] = 1e6, 1e6
    value = FatigueLoads(cycles=cycles).damage(_JOINTS, np.full(2, 4.0), np.full(2, 0.03)).value
    assert value[0] == value[1]
    cycles[1, 1] = 0.0
    alone = FatigueLoads(cycles=cycles).damage(_JOINTS, np.full(2, 4.0), np.full(2, 0.03)).value
    assert alone[1] == value[1]


@pytest.mark.parametrize("wall", [0.015, 0.0245, 0.025, 0.0255, 0.05])
def test_slopes_are_the_differences(loads: FatigueLoads, wall: float) -> None:
    joints = station_joints(19, 10)
    d, t = np.linspace(5.0, 3.0, 20), np.full(20, wall)
    damage = loads.damage(joints, d, t)
    h = 5e-4  # as wide as the slopes' own difference
    by_d = np.log(
        loads.damage(joints, d * np.exp(h / 5), t).value
        / loads.damage(joints, d * np.exp(-h / 5), t).value
    ) / (2.0 * h / 5)
    by_t = np.log(
        loads.damage(joints, d, t * np.exp(h)).value / loads.damage(joints, d, t * np.exp(-h)).value
    ) / (2.0 * h)
    assert damage.by_diameter == pytest.approx(by_d, rel=2e-3)
    assert damage.by_thickness == pytest.approx(by_t, rel=2e-3)


def test_thickness_acts_beyond_the_reference() -> None:
    weld = Weld(thickness_exponent=0.2)
    plain = Weld(thickness_exponent=0.0)
    d, t = np.full(3, 4.0), np.array([0.01, 0.025, 0.05])
    ratio = weld.stress_per_moment(d, t)[0] / plain.stress_per_moment(d, t)[0]
    assert ratio[0] == pytest.approx(1.0, abs=1e-12)
    assert 1.0 < ratio[1] < 1.003
    assert ratio[2] == pytest.approx(2.0**0.2, rel=1e-12)


def test_ranges_fall_into_the_nearest_bin() -> None:
    ranges = np.array([*(MOMENT_BINS[[0, 10, 1000]] * np.array([1.0, 1.004, 0.996])), 1.0, 1e12])
    signals = ranges[:, None] * np.array([0.0, 1.0, 0.0])
    found = range_spectra(
        signals, first=float(MOMENT_BINS[0]), width=BIN_WIDTH, bins=MOMENT_BINS.size
    )
    assert found.argmax(axis=1).tolist() == [0, 10, 1000, 0, MOMENT_BINS.size - 1]
    np.testing.assert_array_equal(found.sum(axis=1), 1.0)  # two halves


@pytest.mark.parametrize(
    ("cycles", "match"),
    [
        (np.zeros((2, 2, 5)), "expected"),
        (np.zeros((0, 2, MOMENT_BINS.size)), "expected"),
        (np.full((2, 1, MOMENT_BINS.size), -1.0), "at least 0"),
        (np.full((2, 1, MOMENT_BINS.size), np.nan), "NaN"),
    ],
)
def test_bad_cycles(cycles: FloatArray, match: str) -> None:
    with pytest.raises(InputError, match=match):
        FatigueLoads(cycles=cycles)


def test_bad_weld() -> None:
    with pytest.raises(InputError, match="safety_factor"):
        Weld(safety_factor=0.0)
