"""Individual pitch profiles for wind turbines.

Given a turbine, a wind field over its rotor disc and the limits of its pitch actuators, find
the pitch profile beta(psi) that trades mean torque against the variation of torque, tilt, yaw
and thrust, and bound how far it is from the global optimum; or simulate the turbine under a
controller in turbulence (`pitchopt.sim`, `pitchopt.control`, `pitchopt.fatigue`).

Public names load on first use, so that ``import pitchopt`` stays short.  Signs, units and
symbols: NOMENCLATURE.md; derivations: docs/theory.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from pitchopt.errors import ComputationError, InfeasibleError, InputError, PitchoptError

if TYPE_CHECKING:
    from pitchopt.aero.blade import Blade
    from pitchopt.aero.curves import BladeCurves
    from pitchopt.aero.fits import PolarFit, fit_polar
    from pitchopt.aero.polars import Polar
    from pitchopt.aero.rotor import Rotor
    from pitchopt.aero.static_rotor import StaticRotor
    from pitchopt.cases import Case, load_case
    from pitchopt.design import (
        CurvesModel,
        Design,
        DesignTask,
        LoadWeights,
        PitchLimits,
        Several,
        Status,
        Tradeoff,
        compared,
        power_max,
        robust,
        schedule,
        tradeoff,
    )
    from pitchopt.fatigue import damage_equivalent_load
    from pitchopt.sim import DynamicTurbine, Operation, simulate, simulate_many
    from pitchopt.turbines import Turbine, load_turbine, read_windio

__all__ = [
    "Blade",
    "BladeCurves",
    "Case",
    "ComputationError",
    "CurvesModel",
    "Design",
    "DesignTask",
    "DynamicTurbine",
    "InfeasibleError",
    "InputError",
    "LoadWeights",
    "Operation",
    "PitchLimits",
    "PitchoptError",
    "Polar",
    "PolarFit",
    "Rotor",
    "Several",
    "StaticRotor",
    "Status",
    "Tradeoff",
    "Turbine",
    "__version__",
    "compared",
    "damage_equivalent_load",
    "fit_polar",
    "load_case",
    "load_turbine",
    "power_max",
    "read_windio",
    "robust",
    "schedule",
    "simulate",
    "simulate_many",
    "tradeoff",
]

__version__ = "0.1.0"

_HOME = {
    "Blade": "pitchopt.aero.blade",
    "BladeCurves": "pitchopt.aero.curves",
    "Case": "pitchopt.cases",
    "CurvesModel": "pitchopt.design",
    "Design": "pitchopt.design",
    "DesignTask": "pitchopt.design",
    "DynamicTurbine": "pitchopt.sim",
    "LoadWeights": "pitchopt.design",
    "Operation": "pitchopt.sim",
    "PitchLimits": "pitchopt.design",
    "Polar": "pitchopt.aero.polars",
    "PolarFit": "pitchopt.aero.fits",
    "Rotor": "pitchopt.aero.rotor",
    "Several": "pitchopt.design",
    "StaticRotor": "pitchopt.aero.static_rotor",
    "Status": "pitchopt.design",
    "Tradeoff": "pitchopt.design",
    "Turbine": "pitchopt.turbines",
    "compared": "pitchopt.design",
    "damage_equivalent_load": "pitchopt.fatigue",
    "fit_polar": "pitchopt.aero.fits",
    "load_case": "pitchopt.cases",
    "load_turbine": "pitchopt.turbines",
    "power_max": "pitchopt.design",
    "read_windio": "pitchopt.turbines",
    "robust": "pitchopt.design",
    "schedule": "pitchopt.design",
    "simulate": "pitchopt.sim",
    "simulate_many": "pitchopt.sim",
    "tradeoff": "pitchopt.design",
}


def __getattr__(name: str) -> Any:
    """Load a public name from its module on first use (PEP 562)."""
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, loaded or not."""
    return sorted(set(globals()) | set(__all__))
