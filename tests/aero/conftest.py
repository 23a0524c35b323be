"""Rotors, wind and reference tables for the tests of the aerodynamics."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pitchopt.aero import Blade, Polar, Rotor, StaticRotor
from pitchopt.turbines import load_turbine
from windfield import PowerLaw, StaticField, TowerShadow

Table = list[dict[str, str]]
LOADS = ("torque", "thrust", "tilt", "yaw", "outofplane", "inplane")


def sheared(speed: float, *, tower: bool = False, exponent: float = 0.2) -> StaticField:
    """Power-law wind at the NREL 5 MW, with or without its tower."""
    shadow = TowerShadow(radius=[3.0, 1.935, 1.935], height=[0.0, 85.268, 87.6], top=87.6)
    return StaticField(
        speed=speed,
        hub_height=90.0,
        vertical=PowerLaw(exponent=exponent),
        tower=shadow if tower else None,
    )


@pytest.fixture(scope="session")
def wind() -> Callable[..., StaticField]:
    """Maker of sheared wind."""
    return sheared


@pytest.fixture(scope="session")
def nrel() -> Rotor:
    """NREL 5 MW with tilt and cone."""
    return load_turbine("nrel-5mw").rotor


@pytest.fixture(scope="session")
def nrel_variants(nrel: Rotor) -> dict[str, Rotor]:
    """The two geometries of the reference data."""
    plain = Rotor(
        blade=nrel.blade,
        blades=nrel.blades,
        hub_radius=nrel.hub_radius,
        overhang=nrel.overhang,
        hub_height=nrel.hub_height,
    )
    return {"ref": nrel, "c0t0": plain}


@pytest.fixture(scope="session")
def outboard(nrel: Rotor) -> Polar:
    """Polar of the blade tip (NACA 64-618)."""
    return nrel.blade.polars[-1]


@pytest.fixture(scope="session")
def paper_rotor(outboard: Polar) -> Callable[[int], Rotor]:
    """Rotor of the two-element example: R = 40 m, root at 8 m, constant chord."""

    def make(elements: int) -> Rotor:
        radius = 8.0 + 32.0 * (np.arange(elements) + 0.5) / elements
        blade = Blade(
            span=radius - 8.0,
            chord=np.full(elements, 0.96),
            twist=np.arctan(15.0 / (2.0 * radius)) - np.arctan(15.0 / 80.0),
            polars=(outboard,) * elements,
            quadrature="elements",
        )
        return Rotor(blade=blade, hub_radius=8.0, overhang=5.5, hub_height=80.0)

    return make


@pytest.fixture(scope="session")
def paper(paper_rotor: Callable[[int], Rotor]) -> Callable[[int], StaticRotor]:
    """The two-element example in sheared wind, with any number of elements."""

    def make(elements: int = 2) -> StaticRotor:
        field = StaticField(
            speed=15.0,
            hub_height=80.0,
            vertical=PowerLaw(exponent=0.2),
            horizontal_shear=5e-4,
            tower=TowerShadow(radius=0.93, top=80.0),
        )
        return StaticRotor(
            rotor=paper_rotor(elements),
            wind=field,
            rotor_speed=2.0,
            pitch_range=(-0.35, 0.6),
            alpha_limits=(float(np.deg2rad(-5.0)), None),
            pitch_rate_terms=False,
            radial_moment=False,
        )

    return make


def read_table(path: Path) -> Table:
    """Rows of a CSV table whose comment lines start with #."""
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


@pytest.fixture(scope="session")
def subset() -> Callable[[str], Table]:
    """Reader of the reference subsets that the project holds."""
    return lambda name: read_table(Path(__file__).parent / "data" / name)


def azimuth_errors(
    table: Table, variants: dict[str, Rotor], *, cyclic: bool
) -> dict[tuple[str, ...], dict[str, float]]:
    """Largest error per load and case, as a share of the reference's AC amplitude.

    The amplitude is sqrt(2) times the standard deviation over the turn.
    """
    keys = ("variant", "wind_speed", "rotor_speed", "pitch_mean", "tower", "yaw")
    cases: dict[tuple[str, ...], Table] = defaultdict(list)
    for row in table:
        case = (*(row[key] for key in keys), row.get("skew_redistribution", "1"))
        cases[case].append(row)
    result = {}
    for case, rows in cases.items():
        name, speed, rpm, mean, tower, yaw, skew = case
        rotor = variants[name]
        omega = float(rpm) * np.pi / 30.0
        model = StaticRotor(
            rotor=rotor,
            wind=sheared(float(speed), tower=tower == "1"),
            rotor_speed=omega,
            yaw=float(np.deg2rad(float(yaw))),
            induction="equilibrium",
            skew=skew == "1",
        )
        column = {
            key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key != "variant"
        }
        psi = np.deg2rad(column["azimuth"])[:, None] + 2 * np.pi * np.arange(3) / 3
        pitch = np.full(psi.shape, np.deg2rad(float(mean)))
        rate = np.zeros(psi.shape)
        if cyclic:
            pitch += np.deg2rad(2.0 * np.cos(psi) + np.cos(2 * psi))
            rate -= np.deg2rad(2.0 * np.sin(psi) + 2.0 * np.sin(2 * psi)) * omega
        loads = model.blade_loads(psi, pitch, rate)
        c, s = np.cos(psi), np.sin(psi)
        cc, sc = np.cos(rotor.cone), np.sin(rotor.cone)
        lever = rotor.hub_radius
        ours = {
            "torque": loads.torque.sum(axis=1),
            "thrust": loads.thrust.sum(axis=1),
            "tilt": (loads.bending * c - loads.radial * s).sum(axis=1),
            "yaw": (loads.bending * s + loads.radial * c).sum(axis=1),
            "outofplane": loads.bending[:, 0] - lever * loads.thrust[:, 0] / cc,
            "inplane": cc * loads.torque[:, 0]
            + sc * loads.radial[:, 0]
            + lever * column["root_inplane_force"],
        }
        theirs = {
            "torque": column["hub_torque"],
            "thrust": column["hub_thrust"],
            "tilt": column["hub_tilt_moment"],
            "yaw": column["hub_yaw_moment"],
            "outofplane": column["root_outofplane_moment"],
            "inplane": column["root_inplane_moment"],
        }
        result[case] = {
            load: float(np.abs(ours[load] - ref).max() / (np.sqrt(2.0) * ref.std()))
            for load, ref in theirs.items()
        }
    return result


@pytest.fixture(scope="session")
def errors_over_azimuth() -> Callable[..., dict[tuple[str, ...], dict[str, float]]]:
    """`azimuth_errors` for the test modules."""
    return azimuth_errors
