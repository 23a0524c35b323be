"""A turbine, its wind and its controller, compiled once for all tests of the simulator."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pitchopt.control import TurbineController, nrel_5mw_baseline
from pitchopt.sim import DynamicTurbine
from pitchopt.turbines import Turbine, load_turbine
from windfield import PowerLaw, StaticField, TowerShadow


@pytest.fixture(scope="session")
def nrel() -> Turbine:
    return load_turbine("nrel-5mw")


@pytest.fixture(scope="session")
def dynamic(nrel: Turbine) -> DynamicTurbine:
    return DynamicTurbine(turbine=nrel, step=0.025)


@pytest.fixture(scope="session")
def sheared(nrel: Turbine) -> Callable[[float], StaticField]:
    """Steady wind with shear and tower, as in the reference data."""
    tower = TowerShadow(radius=nrel.tower.radius, height=nrel.tower.height, top=nrel.tower.top)

    def field(speed: float) -> StaticField:
        return StaticField(
            speed=speed, hub_height=90.0, vertical=PowerLaw(exponent=0.2), tower=tower
        )

    return field


@pytest.fixture
def controller() -> TurbineController:
    return nrel_5mw_baseline()
