"""Operating points, performance surfaces and their sensitivities."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.aero import OperatingPoints, Rotor, mean_loads, operating_points, performance
from pitchopt.aero.steady import UniformInflow
from pitchopt.errors import InputError

RATED = 5.2966e6
FASTEST = 12.1 * np.pi / 30.0
SLOWEST = 6.9 * np.pi / 30.0


@pytest.fixture(scope="module")
def points(nrel: Rotor) -> OperatingPoints:
    return operating_points(
        nrel,
        [4.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0],
        rated_power=RATED,
        optimal_tip_speed_ratio=7.55,
        rated_rotor_speed=FASTEST,
        min_rotor_speed=SLOWEST,
        azimuths=6,
    )


class TestOperatingPoints:
    def test_regions(self, points: OperatingPoints, nrel: Rotor) -> None:
        assert points.rotor_speed[0] == SLOWEST
        ratio = points.rotor_speed * nrel.radius / points.wind_speed
        assert ratio[2] == pytest.approx(7.55)
        np.testing.assert_allclose(points.pitch[:4], 0.0)
        np.testing.assert_allclose(points.rotor_speed[4:], FASTEST)
        np.testing.assert_allclose(points.power[4:], RATED, rtol=1e-7)
        assert np.all(np.diff(points.pitch[4:]) > 0.0)

    def test_known_pitch(self, points: OperatingPoints) -> None:
        """Pitch of the baseline turbine in steady wind (NREL/TP-500-38060, table 7-1).

        The table is for an elastic rotor: 12 m/s 3.83, 15 m/s 10.45, 20 m/s 17.47,
        25 m/s 23.47 degrees.
        """
        got = np.rad2deg(points.pitch[4:])
        np.testing.assert_allclose(got, [3.83, 10.45, 17.47, 23.47], atol=0.5)

    def test_consistency(self, points: OperatingPoints, nrel: Rotor) -> None:
        np.testing.assert_allclose(points.power, points.torque * points.rotor_speed)
        pressure = 0.5 * 1.225 * np.pi * nrel.radius**2 * points.wind_speed**2
        np.testing.assert_allclose(points.cp, points.power / (pressure * points.wind_speed))
        np.testing.assert_allclose(points.ct, points.thrust / pressure)
        assert points.cp.max() < 16.0 / 27.0

    def test_sensitivities(self, points: OperatingPoints, nrel: Rotor) -> None:
        for i in (2, 5, 7):
            omega = float(points.rotor_speed[i])
            field = UniformInflow(float(points.wind_speed[i]))
            step = np.deg2rad(0.1)
            torque, thrust = mean_loads(
                nrel, field, omega, points.pitch[i] + np.array([-step, step]), azimuths=6
            )
            power_slope = (torque[1] - torque[0]) * omega / (2 * step)
            thrust_slope = (thrust[1] - thrust[0]) / (2 * step)
            assert points.power_sensitivity[i] == pytest.approx(power_slope, rel=0.03, abs=1e5)
            assert points.thrust_sensitivity[i] == pytest.approx(thrust_slope, rel=0.03)
        assert np.all(points.thrust_sensitivity < 0.0)
        assert np.all(np.diff(points.power_sensitivity[4:]) < 0.0)

    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"wind_speed": [-1.0]}, "wind_speed"),
            ({"rated_power": 0.0}, "rated_power"),
            ({"rated_rotor_speed": 0.1}, "rated_rotor_speed"),
            ({"max_pitch": -0.1}, "max_pitch"),
            ({"wind_speed": [25.0], "max_pitch": 0.05}, "max_pitch"),
        ],
    )
    def test_bad_input(self, nrel: Rotor, change: dict[str, object], word: str) -> None:
        values: dict[str, object] = {
            "wind_speed": [10.0],
            "rated_power": RATED,
            "optimal_tip_speed_ratio": 7.55,
            "rated_rotor_speed": FASTEST,
            "min_rotor_speed": SLOWEST,
        }
        with pytest.raises(InputError, match=word):
            operating_points(nrel, **{**values, **change})


class TestPerformance:
    def test_surface(self, nrel: Rotor) -> None:
        surfaces = performance(nrel, [6.0, 7.5, 9.0], np.deg2rad([0.0, 5.0]), azimuths=6)
        assert surfaces.cp.shape == surfaces.ct.shape == (3, 2)
        assert surfaces.best() == (7.5, 0.0, surfaces.cp[1, 0])
        assert surfaces.cp[1, 0] == pytest.approx(0.4807, abs=3e-4)
        assert np.all(np.diff(surfaces.ct[:, 0]) > 0.0)

    def test_does_not_depend_on_wind_speed(self, nrel: Rotor) -> None:
        one, two = (
            performance(nrel, [5.0, 8.0], [0.0, 0.1], wind_speed=u, azimuths=2).cp
            for u in (6.0, 17.0)
        )
        np.testing.assert_allclose(one, two, rtol=1e-9)

    @pytest.mark.parametrize("azimuths", [0, 2.5, True])
    def test_bad_azimuths(self, nrel: Rotor, azimuths: object) -> None:
        with pytest.raises(InputError, match="azimuths"):
            mean_loads(nrel, UniformInflow(8.0), 1.0, 0.0, azimuths=azimuths)

    def test_bad_ratio(self, nrel: Rotor) -> None:
        with pytest.raises(InputError, match="tip_speed_ratio"):
            performance(nrel, [-1.0], [0.0])
