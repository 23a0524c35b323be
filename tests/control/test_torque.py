"""The torque law against the report's numbers, its continuity, its input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from control_factories import measured
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import TorqueLaw, nrel_5mw_baseline
from pitchopt.control import signals as s
from pitchopt.errors import InputError

NREL = nrel_5mw_baseline().torque
POWER = 5296610.0


def law(**changes: Any) -> TorqueLaw:
    numbers: dict[str, Any] = {
        "gain": 2.3,
        "rated_power": POWER,
        "rated_speed": 121.7,
        "largest_torque": 48000.0,
        "largest_rate": 15000.0,
    }
    return TorqueLaw(**(numbers | changes))


class TestReport:
    def test_end_of_region_2_is_the_reports_speed(self) -> None:
        # NREL/TP-500-38060, table 7-2: region 2 1/2 starts at 1136.496 rpm
        assert np.isclose(NREL.transition_speed * 30 / np.pi, 1136.496, atol=5e-4)

    def test_rated_slip_reaches_rated_torque(self) -> None:
        assert np.isclose(NREL.synchronous_speed * 1.1, 121.6805, rtol=1e-12)
        assert np.isclose(NREL.torque(121.6805 - 1e-9), 43528.83, atol=0.1)

    @pytest.mark.parametrize(
        ("speed", "expected"),
        [
            (50.0, 0.0),
            (70.16224, 0.0),
            (80.0, 2.332287 * 91.21091**2 / (91.21091 - 70.16224) * (80.0 - 70.16224)),
            (100.0, 2.332287 * 100.0**2),
            (120.0, POWER / 121.6805 / (121.6805 / 11.0) * (120.0 - 121.6805 / 1.1)),
            (130.0, POWER / 130.0),
        ],
    )
    def test_regions(self, speed: float, expected: float) -> None:
        assert np.isclose(NREL.torque(speed), expected, rtol=1e-10)

    def test_one_degree_of_pitch_is_region_3_at_any_speed(self) -> None:
        assert np.isclose(NREL.torque(118.0, np.radians(1.0)), POWER / 118.0, rtol=1e-12)
        assert np.isclose(NREL.torque(118.0, np.radians(0.99)), 2.332287 * 118.0**2, rtol=1e-12)
        assert NREL.torque(60.0, 0.5) == 47402.91
        assert NREL.torque(0.0, 0.5) == POWER / 121.6805

    def test_constant_torque(self) -> None:
        assert law(constant_power=False).torque(150.0) == POWER / 121.7


@given(
    factor=st.floats(0.3, 1.7),
    constant_power=st.booleans(),
    slip=st.sampled_from([None, 0.05, 0.1]),
    start=st.sampled_from([(0.0, 0.0), (60.0, 80.0)]),
)
def test_the_law_is_continuous_for_every_factor(
    factor: float, constant_power: bool, slip: float | None, start: tuple[float, float]
) -> None:
    some = law(
        factor=factor,
        constant_power=constant_power,
        slip=slip,
        cut_in_speed=start[0],
        region2_speed=start[1],
        largest_torque=1e6,
    )
    for corner in (*start, some.transition_speed, some.region3_speed):
        if corner > 0.0:
            below, above = some.torque(corner * (1 - 1e-9)), some.torque(corner * (1 + 1e-9))
            assert abs(above - below) < 1e-4 * some.rated_torque
    assert some.region3_speed <= some.rated_speed or slip is None
    inside = 0.5 * (max(start[1], 1.0) + some.transition_speed)
    assert np.isclose(some.torque(inside), factor * 2.3 * inside**2, rtol=1e-12)


def test_plain_law_reaches_rated_power_where_its_curve_does() -> None:
    plain = law(slip=None)
    end = plain.transition_speed
    assert np.isclose(2.3 * end**3, POWER, rtol=1e-12)
    assert plain.region3_speed == end
    assert np.isclose(plain.torque(1e-3), 2.3e-6, rtol=1e-12)


def test_the_rate_limits_the_command() -> None:
    controller = nrel_5mw_baseline()
    controller.start(0.01, measured(rotor_speed=1.25, generator_torque=40000.0, pitch=0.0))
    first = controller.command(measured(rotor_speed=0.8, pitch=0.0))[s.TORQUE]
    second = controller.command(measured(rotor_speed=0.2, pitch=0.0))[s.TORQUE]
    assert second == first - 150.0 or first > second >= first - 150.0
    assert abs(first - 40000.0) <= 150.0


def test_turbine_numbers_of_the_nrel_5mw_give_nearly_its_law() -> None:
    same = TorqueLaw.from_turbine_numbers(
        gain=2.332287, rated_power=POWER, rated_speed=122.9096, least_speed=70.16224
    )
    for name in ("rated_speed", "region2_speed", "largest_torque", "largest_rate"):
        assert np.isclose(getattr(same, name), getattr(NREL, name), rtol=2e-3)
    assert np.isclose(same.transition_speed, NREL.transition_speed, rtol=1e-4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gain": 0.0}, "gain: got 0.0"),
        ({"rated_power": -1.0}, "rated_power"),
        ({"rated_speed": np.nan}, "rated_speed"),
        ({"largest_rate": np.inf}, "largest_rate"),
        ({"factor": -0.3}, "factor"),
        ({"slip": 0.0}, "slip"),
        ({"region3_pitch": np.nan}, "region3_pitch: got nan"),
        ({"largest_torque": 1000.0}, "expected at least the rated torque"),
        ({"cut_in_speed": 80.0, "region2_speed": 70.0}, "region2_speed"),
        ({"cut_in_speed": 80.0, "region2_speed": 80.0}, "region 1.5"),
        ({"region2_speed": 121.0}, "below the end of region 2"),
    ],
)
def test_bad_input(changes: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        law(**changes)
