"""Momentum balance: limits, residual, brackets, energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.aero import Momentum, Polar, Rotor
from pitchopt.aero.induction import (
    Induction,
    SectionPolars,
    axial_induction,
    loss_factor,
    skew_redistribution,
    solve_bracketed,
    solve_induction,
)

FAR = np.array([1e9])


def lift(slope: float = 2 * np.pi, drag: float = 0.0) -> Polar:
    """Linear lift, constant drag."""
    return Polar(alpha=[-np.pi, np.pi], cl=[-slope * np.pi, slope * np.pi], cd=[drag, drag])


def solve(
    polar: Polar,
    normal: float,
    tangential: float,
    theta: float,
    solidity: float,
    swirl: bool = True,
) -> Induction:
    """One section without losses."""
    return solve_induction(
        SectionPolars((polar,)),
        np.array([normal]),
        np.array([tangential]),
        np.array([theta]),
        np.array([solidity]),
        FAR,
        FAR,
        Momentum(tip_loss=False, hub_loss=False, tangential=swirl),
    )


class TestRootFinder:
    @given(st.floats(-0.9, 0.9), st.floats(0.1, 20.0))
    def test_finds_roots(self, root: float, steepness: float) -> None:
        def function(x, index):
            return np.tanh(steepness * (x - root)) * (1.0 + index)

        low, high = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
        index = np.arange(2)
        found = solve_bracketed(function, low, high, function(low, index), function(high, index))
        np.testing.assert_allclose(found, root, atol=1e-11)

    def test_root_on_an_end(self) -> None:
        low, high = np.array([0.0, -1.0]), np.array([1.0, 0.0])
        found = solve_bracketed(lambda x, _: x, low, high, low.copy(), high.copy())
        np.testing.assert_allclose(found, 0.0, atol=1e-12)


class TestPieces:
    def test_loss_limits(self) -> None:
        sin_phi = np.array([0.1])
        assert loss_factor(sin_phi, FAR, FAR)[0] == pytest.approx(1.0)
        assert loss_factor(sin_phi, np.array([1e-12]), FAR)[0] == pytest.approx(1e-4)
        half = -0.1 * np.log(np.cos(np.pi / 4))  # F = 1/2 where exp(-f) = cos(pi / 4)
        assert loss_factor(sin_phi, np.array([half]), FAR)[0] == pytest.approx(0.5)

    @pytest.mark.parametrize("loss", [1.0, 0.7, 0.2])
    def test_regions_join(self, loss: float) -> None:
        f = np.array([loss])
        below = axial_induction(np.array([2.0 / 3.0]), f)[0]
        above = axial_induction(np.array([2.0 / 3.0 + 1e-9]), f)[0]
        assert below == pytest.approx(0.4)
        assert above == pytest.approx(0.4, abs=1e-7)

    def test_buhl_thrust(self) -> None:
        """C_t = 8/9 + (4 F - 40/9) a + (50/9 - 4 F) a^2 for a > 0.4."""
        kappa = np.linspace(0.7, 30.0, 50)
        for loss in (1.0, 0.6, 0.3):
            a = axial_induction(kappa, np.full(50, loss))
            thrust = 8 / 9 + (4 * loss - 40 / 9) * a + (50 / 9 - 4 * loss) * a**2
            np.testing.assert_allclose(4 * loss * kappa * (1 - a) ** 2, thrust, rtol=1e-9)

    def test_skew_has_no_effect_on_the_mean(self) -> None:
        psi = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
        a = skew_redistribution(np.full(24, 0.3), np.full(24, 0.2), np.full(24, 0.8), np.sin(psi))
        assert a.mean() == pytest.approx(0.3)
        assert a[6] == a.max()
        expected = 0.3 * (1 + 15 * np.pi / 32 * np.tan(1.18 * 0.2 / 2) * 0.8)
        assert a.max() == pytest.approx(expected)


class TestBalance:
    @pytest.mark.parametrize("a", [0.1, 1.0 / 3.0, 0.39])
    def test_prescribed_axial_induction(self, a: float) -> None:
        """Lift chosen so that momentum theory without swirl gives a known a."""
        normal, tangential, solidity = 10.0, 60.0, 0.05
        phi = np.arctan2(normal * (1 - a), tangential)
        cn = a / (1 - a) * 4 * np.sin(phi) ** 2 / solidity
        theta = phi - cn / np.cos(phi) / (2 * np.pi)
        result = solve(lift(), normal, tangential, theta, solidity, swirl=False)
        assert result.axial[0] == pytest.approx(a, abs=1e-10)
        assert result.phi[0] == pytest.approx(phi, abs=1e-11)
        assert result.tangential[0] == 0.0

    @given(
        st.floats(1.0, 30.0),
        st.floats(3.0, 100.0),
        st.floats(-0.2, 0.5),
        st.floats(0.005, 0.3),
    )
    def test_forces_balance(
        self, normal: float, tangential: float, theta: float, solidity: float
    ) -> None:
        """Blade forces equal momentum changes wherever the momentum region holds."""
        result = solve(lift(4.0, 0.02), normal, tangential, theta, solidity)
        assert result.solved[0]
        a, swirl, phi = result.axial[0], result.tangential[0], result.phi[0]
        cl = 4.0 * (phi - theta)
        if 0.0 < phi < np.pi / 2 and -0.9 < a < 0.4 and abs(swirl) < 0.9:
            u, v = normal * (1 - a), tangential * (1 + swirl)
            assert np.arctan2(u, v) == pytest.approx(phi, abs=1e-9)
            square = u * u + v * v
            thrust = solidity * square * cl * np.cos(phi)
            assert thrust == pytest.approx(4 * a * (1 - a) * normal**2, abs=1e-6 * square)
            torque = solidity * square * cl * np.sin(phi)
            momentum = 4 * swirl * (1 - a) * normal * tangential
            assert torque == pytest.approx(momentum, abs=1e-6 * square)

    @given(st.floats(2.0, 25.0), st.floats(5.0, 90.0), st.floats(-0.3, 1.2))
    def test_always_bracketed(self, normal: float, tangential: float, theta: float) -> None:
        alpha = np.deg2rad([-180.0, -20.0, -10.0, 12.0, 20.0, 90.0, 180.0])
        polar = Polar(alpha=alpha, cl=[0, -0.8, -0.9, 1.4, 0.9, 0.0, 0], cd=[0.1] * 7)
        for options in (Momentum(), Momentum(axial_drag=True, tangential_drag=True)):
            result = solve_induction(
                SectionPolars((polar,)),
                np.array([normal]),
                np.array([tangential]),
                np.array([theta]),
                np.array([0.06]),
                np.array([0.4]),
                np.array([2.0]),
                options,
            )
            assert result.solved[0]
            # the inflow angle of the balance is that of the induced flow
            u, v = normal * (1 - result.axial[0]), tangential * (1 + result.tangential[0])
            if -0.999 < result.axial[0] < 1.499 and abs(result.tangential[0]) < 0.999:
                assert np.arctan2(u, v) == pytest.approx(result.phi[0], abs=1e-7)

    def test_blocked_and_still_sections(self) -> None:
        polars = SectionPolars((lift(), lift(), lift()))
        result = solve_induction(
            polars,
            np.array([8.0, 8.0, 0.0]),
            np.array([60.0, 60.0, 60.0]),
            np.zeros(3),
            np.full(3, 0.05),
            np.array([1.0, 0.0, 1.0]),
            np.array([1.0, 1.0, 1.0]),
        )
        assert result.solved.tolist() == [True, False, False]
        assert result.axial[1] == 1.0
        assert result.axial[2] == 0.0
        assert result.tangential[1] == result.tangential[2] == 0.0

    def test_polars_may_come_in_any_order(self) -> None:
        one, two = lift(6.0), lift(3.0)
        speeds = np.linspace(6.0, 12.0, 5)[:, None] * np.ones(4)
        args = (np.full((5, 4), 50.0), np.full((5, 4), 0.02), np.full(4, 0.05))
        loss = (np.full(4, 2.0), np.full(4, 3.0))
        mixed = solve_induction(SectionPolars((one, two, one, two)), speeds, *args, *loss)
        for column, polar in enumerate((one, two, one, two)):
            single = solve_induction(
                SectionPolars((polar,)),
                speeds[:, :1],
                args[0][:, :1],
                args[1][:, :1],
                args[2][:1],
                loss[0][:1],
                loss[1][:1],
            )
            np.testing.assert_array_equal(mixed.axial[:, column], single.axial[:, 0])
        assert not np.array_equal(mixed.axial[:, 0], mixed.axial[:, 1])


class TestIdealRotor:
    def test_never_beats_betz(self, nrel: Rotor) -> None:
        """Axial momentum theory bounds the power of a drag-free rotor."""
        from pitchopt.aero import Blade, performance

        span = np.linspace(0.0, 60.0, 25)
        radius = span + 3.0
        ratio = 8.0
        # optimum of simple momentum theory at every radius: a = 1/3, design lift 0.9
        local = ratio * radius / 63.0
        phi = np.arctan(2.0 / (3.0 * local))
        chord = 8 * np.pi * radius * np.sin(phi) / (3 * 3 * local * 0.9)
        ideal = Blade(
            span=span,
            chord=chord,
            twist=phi - 0.9 / (2 * np.pi),
            polars=(lift(),) * 25,
        )
        rotor = Rotor(blade=ideal, hub_radius=3.0, hub_height=90.0)
        cp = performance(rotor, [ratio], [0.0], azimuths=1).cp[0, 0]
        assert 0.50 < cp < 16.0 / 27.0
        assert nrel.blades == rotor.blades
