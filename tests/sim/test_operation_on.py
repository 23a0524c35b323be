"""The same rotor on another tower: what is kept, and what is not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, Operation
from pitchopt.studies.tower import scaled_start
from pitchopt.turbines import load_turbine


@pytest.fixture(scope="module")
def iea():
    return load_turbine("iea-3.4-130")


@pytest.fixture(scope="module")
def operation(iea):
    made = Operation(DynamicTurbine(turbine=iea))
    made.linear_quadratic()
    return made


@pytest.fixture(scope="module")
def taller(iea):
    """On a tower that is higher and thicker."""
    design = scaled_start(iea, 125.0)
    thicker = dataclasses.replace(design, thickness=1.3 * design.thickness)
    return DynamicTurbine(turbine=thicker.turbine)


def test_controllers_are_those_of_an_operation_of_its_own(operation, taller):
    moved, alone = operation.on(taller), Operation(taller)
    assert moved.dynamic is taller
    for weight in (0.0, 0.2):
        one = moved.linear_quadratic(tower_velocity=weight)
        two = alone.linear_quadratic(tower_velocity=weight)
        assert one.torque == two.torque
        assert one.pitch_range == two.pitch_range
        assert one.speed_corner == two.speed_corner
        for field in dataclasses.fields(one.pitch):
            left, right = getattr(one.pitch, field.name), getattr(two.pitch, field.name)
            np.testing.assert_array_equal(np.asarray(left), np.asarray(right), err_msg=field.name)
    for speed in (6.0, 13.3, 20.0):
        assert moved.start(speed) == alone.start(speed)
    assert moved.fine_pitch == alone.fine_pitch
    for name in ("torque", "bending"):
        np.testing.assert_array_equal(
            getattr(moved.frozen_slopes, name), getattr(alone.frozen_slopes, name)
        )


def test_tower_is_its_own(operation, taller):
    """Derivatives know the tower's stiffness and mass, so that the regulator does."""
    speeds = np.array([8.0, 15.0])
    here, there = operation.derivatives(speeds), operation.on(taller).derivatives(speeds)
    np.testing.assert_array_equal(here.torque_by_pitch, there.torque_by_pitch)
    np.testing.assert_array_equal(here.thrust_by_wind, there.thrust_by_wind)
    assert there.tower_stiffness != pytest.approx(here.tower_stiffness, rel=0.01)
    stiffness = float(taller.tower.stiffness[0] - taller.body_tables.tower_weight[0])
    assert there.tower_stiffness == stiffness
    assert there.tower_mass != pytest.approx(here.tower_mass, rel=0.01)


def test_nothing_of_the_rotor_is_computed_again(operation, taller, monkeypatch):
    moved = operation.on(taller)
    for name in ("performance", "operating_points", "StaticRotor"):
        monkeypatch.setattr(
            f"pitchopt.sim.operation.{name}", lambda *_, **__: pytest.fail("computed again")
        )
    moved.linear_quadratic(tower_velocity=0.1)
    moved.start(9.3)
    assert moved.surfaces is operation.surfaces
    assert moved.curve is operation.curve
    assert moved.estimator is operation.estimator


def test_fresh_operation_has_nothing_to_give(iea, taller):
    moved = Operation(DynamicTurbine(turbine=iea)).on(taller)
    assert not {"surfaces", "curve", "estimator"} & set(vars(moved))
    assert moved.start(10.0) == Operation(taller).start(10.0)


def test_original_is_left_as_it_was(operation, iea, taller):
    before = operation.derivatives([9.0, 12.0]).tower_stiffness
    operation.on(taller).linear_quadratic(tower_velocity=0.3)
    assert operation.dynamic.turbine is iea
    assert operation.derivatives([9.0, 12.0]).tower_stiffness == before


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("rated_power", 3.5e6),
        ("rated_rotor_speed", 1.3),
        ("min_rotor_speed", 0.3),
        ("air_density", 1.1),
        ("fine_pitch", 0.02),
        ("optimal_tip_speed_ratio", 8.5),
        ("cut_in_wind_speed", 3.5),
        ("cut_out_wind_speed", 27.0),
    ],
)
def test_another_machine_is_refused(operation, taller, key, value):
    other = DynamicTurbine(turbine=dataclasses.replace(taller.turbine, **{key: value}))
    with pytest.raises(InputError, match=f"dynamic: its {key} is another"):
        operation.on(other)


@pytest.mark.parametrize("key", ["tilt", "overhang"])
def test_another_rotor_is_refused(operation, taller, key):
    turbine = taller.turbine
    rotor = dataclasses.replace(turbine.rotor, **{key: 1.1 * getattr(turbine.rotor, key)})
    with pytest.raises(InputError, match=f"dynamic: its {key} is another"):
        operation.on(DynamicTurbine(turbine=dataclasses.replace(turbine, rotor=rotor)))


def test_another_inertia_is_refused(operation, taller):
    """The wind estimator knows it."""
    turbine = taller.turbine
    blade = dataclasses.replace(
        turbine.blade_structure, mass_per_length=1.1 * turbine.blade_structure.mass_per_length
    )
    with pytest.raises(InputError, match="its blade_structure is another"):
        operation.on(DynamicTurbine(turbine=dataclasses.replace(turbine, blade_structure=blade)))
    heavier = DynamicTurbine(turbine=turbine, generator_inertia=1.5 * taller.generator_inertia)
    with pytest.raises(InputError, match="its generator_inertia is another"):
        operation.on(heavier)
