"""Lightest towers: closed forms, optimality, other solvers, multipliers, statuses."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.fatigue import SNCurve
from pitchopt.studies.tower.constraints import (
    Rows,
    TowerConstraints,
    constraint_rows,
    tower_constraints,
)
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.fatigue_loads import (
    MOMENT_BINS,
    FatigueLoads,
    Weld,
    section_modulus,
)
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.search import Found, lightest
from pitchopt.studies.tower.sizing import Sizing, scaled_start, size_tower
from pitchopt.turbines import Turbine

Loads = Callable[..., FatigueLoads]
STANDARD = TowerLimits()
SOFT = TowerLimits(frequency_margin=None)
_SLOPE = 4.0
_PLAIN = Weld(
    curve=SNCurve(slope=_SLOPE, reference_range=80e6, reference_cycles=2e6),
    thickness_exponent=0.0,
)


def _one_range(stations: int, cycles: FloatArray | float) -> FatigueLoads:
    """Cycles of one range at each station, on a curve of one slope."""
    counts = np.zeros((stations, 1, MOMENT_BINS.size))
    counts[:, 0, 900] = cycles
    return FatigueLoads(cycles=counts, weld=_PLAIN)


def _needed_modulus(cycles: FloatArray | float) -> FloatArray:
    """W at which the damage of `_one_range` is one."""
    stress = _PLAIN.safety_factor * MOMENT_BINS[900] / 80e6
    return np.asarray(stress * (np.asarray(cycles) / 2e6) ** (1.0 / _SLOPE))


def _all(groups: TowerConstraints) -> FloatArray:
    return np.concatenate([values for _, values in groups.items()])


@pytest.fixture(scope="module")
def standard(turbine: Turbine, loads: FatigueLoads) -> Sizing:
    return size_tower(110.0, loads, STANDARD, turbine, tolerance=1e-8)


@pytest.fixture(scope="module")
def soft(turbine: Turbine, loads: FatigueLoads) -> Sizing:
    return size_tower(110.0, loads, SOFT, turbine, tolerance=1e-8)


# closed forms


def test_uniform_tower_under_one_moment(turbine: Turbine) -> None:
    """Fatigue and D / t alone: W = pi/4 (r - 1) ((r - 1)^2 + 1) t^3 / r, m in W^(2/3)."""
    found = size_tower(110.0, _one_range(19, 1e7), SOFT, turbine, tolerance=1e-9)
    r = SOFT.slenderness
    t = np.cbrt(_needed_modulus(1e7) * 4.0 * r / (np.pi * (r - 1.0) * ((r - 1.0) ** 2 + 1.0)))
    assert found.converged
    assert r * t > SOFT.top_diameter  # which does not bind
    assert found.design.thickness == pytest.approx(np.full(10, t), rel=1e-7)
    assert found.design.diameter == pytest.approx(np.full(11, (r - 1.0) * t), rel=1e-7)
    design = found.design
    assert found.mass == pytest.approx(8500.0 * np.pi * design.length * (r - 1.0) * t**2)
    # W_needed falls with the damage allowed to the power -1 / slope
    total = found.multipliers.fatigue.sum()
    assert total == pytest.approx(2.0 / (3.0 * _SLOPE) * found.mass, rel=1e-4)
    assert set(found.active()) <= {"fatigue", "slenderness", "widening"}


def test_tower_without_loads_keeps_the_bearing(turbine: Turbine) -> None:
    """D_top and D / t alone: t = D_top / r, mass in the square of D_top."""
    found = size_tower(110.0, _one_range(5, 0.0), SOFT, turbine, elements=4, tolerance=1e-9)
    assert found.converged
    t = SOFT.top_diameter / SOFT.slenderness
    assert found.design.thickness == pytest.approx(np.full(4, t), rel=1e-7)
    assert found.design.diameter + t == pytest.approx(np.full(5, SOFT.top_diameter), rel=1e-7)
    assert found.multipliers.top_diameter[0] == pytest.approx(2.0 * found.mass, rel=1e-5)
    assert np.all(found.multipliers.fatigue == 0.0)


def test_tower_without_loads_keeps_the_least_wall(turbine: Turbine) -> None:
    limits = TowerLimits(frequency_margin=None, slenderness=900.0, least_wall=0.02)
    found = size_tower(110.0, _one_range(5, 0.0), limits, turbine, elements=4, tolerance=1e-9)
    assert found.converged
    assert found.design.thickness == pytest.approx(np.full(4, 0.02), rel=1e-7)
    assert found.design.diameter == pytest.approx(np.full(5, 2.98), rel=1e-7)
    # m in t (D_top - t)
    total = found.multipliers.least_wall.sum()
    assert total == pytest.approx(found.mass * (1.0 - 0.02 / 2.98), rel=1e-5)


def test_walls_grow_where_the_diameter_is_at_its_largest(turbine: Turbine) -> None:
    limits = TowerLimits(frequency_margin=None, largest_diameter=3.5)
    found = size_tower(110.0, _one_range(5, 3e7), limits, turbine, elements=4, tolerance=1e-9)
    assert found.converged
    outer = found.design.diameter + np.append(found.design.thickness, found.design.thickness[-1])
    assert outer == pytest.approx(np.full(5, 3.5), rel=1e-7)
    w = section_modulus(found.design.diameter[1:], found.design.thickness)
    assert w == pytest.approx(np.full(4, _needed_modulus(3e7)), rel=1e-7)


def test_mass_follows_the_density(turbine: Turbine, soft: Sizing, loads: FatigueLoads) -> None:
    """Without frequencies the design does not know the density."""
    heavy = dataclasses.replace(
        turbine, tower=dataclasses.replace(turbine.tower, density=2.0 * 8500.0)
    )
    found = size_tower(110.0, loads, SOFT, heavy, tolerance=1e-8)
    assert found.mass == pytest.approx(2.0 * soft.mass, rel=1e-6)
    assert found.design.change_from(soft.design) < 1e-4


# optimality


def _shifted(design: TowerDesign, step: FloatArray) -> TowerDesign:
    nodes = design.diameter.size
    return dataclasses.replace(
        design, diameter=design.diameter + step[:nodes], thickness=design.thickness + step[nodes:]
    )


def _rows(design: TowerDesign, loads: FatigueLoads, limits: TowerLimits) -> Rows:
    return constraint_rows(design, loads, limits)


@pytest.mark.parametrize("limits", [STANDARD, SOFT, TowerLimits(slenderness=120.0)])
def test_conditions_of_the_original_problem(
    turbine: Turbine, loads: FatigueLoads, limits: TowerLimits
) -> None:
    """Mass and g by (d, t) themselves, slopes from differences."""
    found: Found = lightest(scaled_start(turbine, 110.0), loads, limits, tolerance=1e-8, most=50)
    assert found.status == "converged"
    design, rows = found.design, _rows(found.design, loads, limits)
    mass = design.mass
    multipliers = found.multipliers * mass / rows.rate
    assert np.all(multipliers >= 0.0)
    assert np.max(rows.value) <= 1e-7
    assert np.max(np.abs(multipliers * rows.value)) <= 1e-6 * mass
    sizes = np.concatenate([design.diameter, design.thickness])
    for k, unit in enumerate(np.eye(21)):
        h = 1e-4 * sizes[k]
        high, low = _shifted(design, h * unit), _shifted(design, -h * unit)
        slope = (high.mass - low.mass) / (2.0 * h)
        jacobian = (_rows(high, loads, limits).value - _rows(low, loads, limits).value) / (2.0 * h)
        # relative to the mass per relative change
        assert abs(slope + multipliers @ jacobian) * sizes[k] < 2e-5 * mass, k


def test_result_gathers_rows(turbine: Turbine, loads: FatigueLoads, standard: Sizing) -> None:
    values = tower_constraints(standard.design, loads, STANDARD)
    assert np.array_equal(_all(values), _all(standard.constraints))
    assert [v.size for _, v in standard.multipliers.items()] == [
        19,
        2,
        11,
        1,
        10,
        10,
        9,
        10,
        10,
        10,
    ]
    assert standard.multipliers.scaled(2.0).fatigue == pytest.approx(
        2.0 * standard.multipliers.fatigue
    )
    relative = standard.relative_multipliers(1e5)
    assert _all(relative) * 1e5 == pytest.approx(_all(standard.multipliers))
    outer = standard.design.diameter[0] + standard.design.thickness[0]
    assert values.largest_diameter[0] == pytest.approx(outer / 6.0 - 1.0, abs=1e-12)
    frequency = standard.frequencies.value.min(axis=0)
    least = STANDARD.least_frequency(turbine)
    assert least is not None
    assert values.frequency == pytest.approx(1.0 - frequency / least)


def test_upper_ends_are_implied(turbine: Turbine, loads: FatigueLoads) -> None:
    """Left out of the search, kept nonetheless, and without multipliers."""
    found = lightest(scaled_start(turbine, 110.0), loads, STANDARD, tolerance=1e-8, most=50)
    rows = found.rows
    assert rows.implied.sum() == 20
    assert np.all(found.multipliers[rows.implied] == 0.0)
    assert rows.value[rows.implied].max() <= 1e-7
    for name in ("slenderness", "largest_diameter"):
        lower, upper = np.split(rows.value[rows.of(name)], 2)
        assert np.all(upper <= lower + 1e-9)


def test_active_constraints_of_both_configurations(standard: Sizing, soft: Sizing) -> None:
    assert "frequency" in standard.active()
    assert standard.active()["frequency"] == [0]
    assert soft.multipliers.frequency.size == 0
    assert len(soft.active()["fatigue"]) > len(standard.active()["fatigue"])
    assert soft.mass < 0.9 * standard.mass
    assert standard.relative_multipliers().frequency[0] == pytest.approx(
        standard.multipliers.frequency[0] / standard.mass
    )


def _slsqp(
    start: TowerDesign, loads: FatigueLoads, limits: TowerLimits
) -> tuple[float, FloatArray]:
    from scipy.optimize import minimize

    scale = np.concatenate([start.diameter, start.thickness])
    nodes = start.diameter.size

    def design(u: FloatArray) -> TowerDesign:
        x = u * scale
        return dataclasses.replace(start, diameter=x[:nodes], thickness=x[nodes:])

    result = minimize(
        lambda u: design(u).mass / start.mass,
        np.ones(scale.size),
        method="SLSQP",
        constraints=[{"type": "ineq", "fun": lambda u: -_rows(design(u), loads, limits).value}],
        bounds=[(0.3, 3.0)] * scale.size,
        options={"ftol": 1e-11, "maxiter": 200},
    )
    return float(result.fun) * start.mass, result.x * scale


@pytest.mark.parametrize("limits", [STANDARD, SOFT])
def test_sequential_least_squares_finds_the_same(
    turbine: Turbine, weibull_loads: Loads, limits: TowerLimits
) -> None:
    loads = weibull_loads(stations=7)
    found = size_tower(110.0, loads, limits, turbine, elements=4, tolerance=1e-8)
    start = scaled_start(turbine, 110.0, elements=4)
    mass, sizes = _slsqp(start, loads, limits)
    assert found.converged
    assert mass == pytest.approx(found.mass, rel=1e-5)
    own = np.concatenate([found.design.diameter, found.design.thickness])
    assert sizes == pytest.approx(own, rel=2e-3)


def test_geometric_program_finds_the_same(turbine: Turbine) -> None:
    """Stations at nodes and one slope: a geometric program but for (t / d)^2 in W."""
    import cvxpy as cp

    cycles = np.array([6e7, 3e7, 1e7, 2e6, 2e5])
    loads, limits, count = _one_range(5, cycles), SOFT, 4
    found = size_tower(110.0, loads, limits, turbine, elements=count, tolerance=1e-9)
    d, t = cp.Variable(count + 1, pos=True), cp.Variable(count, pos=True)
    modulus = _needed_modulus(cycles)
    part = found.design.length / count
    rules = []
    for e in range(count):
        for n in (e, e + 1):
            rules += [
                float(modulus[n]) * 4.0 / np.pi * (d[n] + t[e]) / (d[n] ** 3 * t[e]) <= 1.0,
                d[n] + t[e] <= limits.largest_diameter,
                d[n] / t[e] <= limits.slenderness - 1.0,
            ]
        rules += [d[e + 1] <= d[e], limits.taper * d[e] <= d[e + 1]]
        rules += [t[e] >= limits.least_wall, t[e] <= limits.largest_wall]
        if e:
            rules += [t[e] <= limits.wall_step * t[e - 1], t[e - 1] <= limits.wall_step * t[e]]
    # the bearing's limit, of the wrong kind for a geometric program, at the optimum's wall
    rules += [d[count] >= limits.top_diameter - float(found.design.thickness[-1])]
    mass = sum(8500.0 * np.pi * part * t[e] * 0.5 * (d[e] + d[e + 1]) for e in range(count))
    problem = cp.Problem(cp.Minimize(mass), rules)
    problem.solve(gp=True, solver=cp.CLARABEL)
    assert found.converged
    assert problem.value == pytest.approx(found.mass, rel=5e-5)
    assert d.value == pytest.approx(found.design.diameter, rel=2e-4)


@pytest.mark.parametrize("limits", [STANDARD, SOFT])
def test_any_start_ends_at_the_same_tower(
    turbine: Turbine, loads: FatigueLoads, limits: TowerLimits
) -> None:
    reference = size_tower(110.0, loads, limits, turbine)
    rng = np.random.default_rng(3)
    for _ in range(8):
        start = TowerDesign(
            hub_height=90.0,
            diameter=rng.uniform(1.0, 8.0, 11),
            thickness=np.exp(rng.uniform(np.log(0.006), np.log(0.15), 10)),
            reference=turbine,
        )
        found = size_tower(110.0, loads, limits, turbine, start)
        assert found.converged
        assert found.mass == pytest.approx(reference.mass, rel=3e-6)
        assert found.iterations < 20
        for name in ("fatigue", "frequency"):  # what the controller and the rotor act on
            mine, theirs = (getattr(s.relative_multipliers(), name) for s in (found, reference))
            assert mine == pytest.approx(theirs, abs=1e-3), name


# multipliers are what a limit costs


@pytest.mark.parametrize(
    ("group", "name", "step", "per_limit"),
    [
        ("fatigue", "largest_damage", 2e-3, lambda v: -1.0 / v),
        ("largest_diameter", "largest_diameter", 2e-3, lambda v: -1.0 / v),
        ("slenderness", "slenderness", 0.05, lambda v: -1.0 / v),
        ("top_diameter", "top_diameter", 2e-3, lambda v: 1.0 / v),
        ("frequency", "frequency_margin", 2e-4, lambda v: 1.0 / (1.0 - v)),
        ("wall_step", "wall_step", 1e-3, lambda v: -1.0 / v),
        ("taper", "taper", 1e-3, lambda v: 1.0 / v),
        ("least_wall", "least_wall", 1e-5, lambda v: 1.0 / v),
        ("largest_wall", "largest_wall", 1e-5, lambda v: -1.0 / v),
    ],
)
def test_multipliers_are_the_slopes_of_the_optimal_mass(
    turbine: Turbine,
    loads: FatigueLoads,
    group: str,
    name: str,
    step: float,
    per_limit: Callable[[float], float],
) -> None:
    """dm / dlimit = sum lambda dg / dlimit, each limit active in one of two designs."""
    tight = TowerLimits(
        frequency_margin=0.08,
        largest_diameter=5.6,
        top_diameter=3.6,
        taper=0.93,
        wall_step=1.06,
        slenderness=150.0,
        least_wall=0.028,
        largest_wall=0.0406,
    )
    cases = {
        "wall_step": TowerLimits(wall_step=1.06, slenderness=170.0),
        "taper": TowerLimits(taper=0.93, frequency_margin=None, slenderness=150.0),
        "least_wall": tight,
        "top_diameter": dataclasses.replace(STANDARD, top_diameter=3.4),
        "largest_diameter": dataclasses.replace(STANDARD, largest_diameter=5.5),
        "largest_wall": TowerLimits(largest_wall=0.034, slenderness=160.0),
    }
    limits = cases.get(group, STANDARD if group != "fatigue" else SOFT)
    values = []
    for sign in (-1.0, 0.0, 1.0):
        other = dataclasses.replace(limits, **{name: getattr(limits, name) + sign * step})
        found = size_tower(110.0, loads, other, turbine, tolerance=1e-8)
        assert found.converged, found.message
        values.append(found)
    low, middle, high = values
    slope = (high.mass - low.mass) / (2.0 * step)
    total = getattr(middle.multipliers, group).sum()
    assert total > 1e-3 * middle.mass  # active
    rate = per_limit(getattr(limits, name))
    assert slope == pytest.approx(total * rate, rel=0.01)


# other sizes, statuses, input


@pytest.mark.parametrize(("elements", "stations"), [(3, 19), (5, 6), (30, 19), (10, 2)])
@pytest.mark.parametrize("limits", [STANDARD, SOFT])
def test_other_numbers_of_elements_and_stations(
    turbine: Turbine, weibull_loads: Loads, elements: int, stations: int, limits: TowerLimits
) -> None:
    loads = weibull_loads(stations=stations)
    found = size_tower(110.0, loads, limits, turbine, elements=elements)
    assert found.converged, found.message
    assert found.constraints.largest[2] < 2e-6
    assert found.multipliers.fatigue.size == stations
    assert found.design.elements == elements


@settings(max_examples=12)
@given(
    hub_height=st.floats(90.0, 130.0),
    slenderness=st.floats(100.0, 300.0),
    largest=st.floats(5.2, 7.0),
    moment=st.floats(2.0, 9.0),
    margin=st.sampled_from([None, 0.0, 0.1]),
)
def test_found_towers_keep_their_limits(
    turbine: Turbine,
    weibull_loads: Loads,
    hub_height: float,
    slenderness: float,
    largest: float,
    moment: float,
    margin: float | None,
) -> None:
    loads = weibull_loads(moment * 1e6, 0.2 * moment * 1e6)
    limits = TowerLimits(frequency_margin=margin, slenderness=slenderness, largest_diameter=largest)
    found = size_tower(hub_height, loads, limits, turbine)
    if found.converged:
        assert found.constraints.largest[2] < 2e-6
        assert found.error <= 1e-6
        assert min(v.min() for _, v in found.multipliers.items() if v.size) >= 0.0
    else:
        assert found.status == "infeasible"
        assert found.constraints.largest[2] > 1e-3


@pytest.mark.parametrize(
    ("limits", "height", "missed"),
    [
        (TowerLimits(), 200.0, "frequency"),
        (TowerLimits(frequency_margin=None, slenderness=20.0), 110.0, "top_diameter"),
        (
            TowerLimits(frequency_margin=None, largest_wall=0.02, largest_diameter=3.5),
            110.0,
            "fatigue|largest_wall|largest_diameter",
        ),
    ],
)
def test_what_no_tower_can_keep(
    turbine: Turbine, loads: FatigueLoads, limits: TowerLimits, height: float, missed: str
) -> None:
    found = size_tower(height, loads, limits, turbine)
    assert found.status == "infeasible"
    assert not found.converged
    assert re.search(f"missed: .*({missed})", found.message)
    assert found.constraints.largest[2] > 0.01


def test_iteration_limit_is_said(turbine: Turbine, loads: FatigueLoads) -> None:
    found = size_tower(110.0, loads, STANDARD, turbine, iterations=2)
    assert found.status == "iteration limit"
    assert found.iterations == 2
    assert "stopped after 2 steps" in found.message


def test_scaled_start_is_the_reference_tower(turbine: Turbine) -> None:
    start = scaled_start(turbine, 110.0)
    assert turbine.tower.mass is not None
    assert start.mass == pytest.approx(turbine.tower.mass, rel=1e-3)
    assert scaled_start(turbine, 121.0).mass == pytest.approx(
        start.mass * (121.0 - 2.0) / 108.0, rel=1e-9
    )
    assert scaled_start(turbine, 110.0, elements=27).mass == pytest.approx(start.mass, rel=0.01)


def test_start_of_another_height_gives_its_sizes_only(
    turbine: Turbine, loads: FatigueLoads, soft: Sizing
) -> None:
    start = scaled_start(turbine, 140.0)
    found = size_tower(110.0, loads, SOFT, turbine, start)
    assert found.design.hub_height == 110.0
    assert found.mass == pytest.approx(soft.mass, rel=3e-6)


def test_warm_start_is_short(turbine: Turbine, loads: FatigueLoads, standard: Sizing) -> None:
    assert size_tower(110.0, loads, STANDARD, turbine, standard.design).iterations <= 3


def test_bad_input(turbine: Turbine, loads: FatigueLoads) -> None:
    with pytest.raises(InputError, match="tolerance"):
        size_tower(110.0, loads, STANDARD, turbine, tolerance=0.0)
    with pytest.raises(InputError, match="iterations"):
        size_tower(110.0, loads, STANDARD, turbine, iterations=0)
    with pytest.raises(InputError, match="elements"):
        size_tower(110.0, loads, STANDARD, turbine, elements=0)
    with pytest.raises(InputError, match="station"):
        size_tower(110.0, FatigueLoads(cycles=loads.cycles[:1]), STANDARD, turbine)
    with pytest.raises(InputError, match="hub_height"):
        size_tower(1.0, loads, STANDARD, turbine)
    bare = dataclasses.replace(turbine, tower=dataclasses.replace(turbine.tower, thickness=None))
    with pytest.raises(InputError, match="walls"):
        size_tower(110.0, loads, STANDARD, bare)
    with pytest.raises(InputError, match="reference_mass"):
        size_tower(110.0, loads, SOFT, turbine).relative_multipliers(0.0)
