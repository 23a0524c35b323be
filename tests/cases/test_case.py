"""Cases: what they build, and what the turbine fills in."""

from __future__ import annotations

import numpy as np
import pytest

import windfield
from pitchopt.aero.curves import BladeCurves
from pitchopt.cases import (
    AeroSettings,
    Case,
    LimitSettings,
    ObjectiveSettings,
    OperationSettings,
    WindSettings,
    builtin_names,
    load_case,
)
from pitchopt.design import LoadWeights
from pitchopt.errors import InputError
from pitchopt.turbines import load_turbine, names

RPM = np.pi / 30


@pytest.fixture
def table(tmp_path):
    azimuth = 2 * np.pi * np.arange(9) / 9
    beta = np.tile(np.deg2rad([-2.0, 3.0, 8.0]), (9, 1))
    load = 1e5 * np.cos(azimuth)[:, None] - 1e6 * beta**2
    curves = BladeCurves(
        blades=3, azimuth=azimuth, beta=beta, torque=load, bending=load, thrust=load
    )
    return curves.save(tmp_path / "curves.npz")


def test_one_case_for_every_turbine():
    assert builtin_names() == names()
    for name in names():
        case = load_case(name)
        assert case.name == case.turbine == name


def test_the_papers_case():
    case = load_case("biegel2011")
    model = case.model()
    assert model.induction == "none"
    assert not model.pitch_rate_terms
    assert not model.radial_moment
    assert model.segments == 40
    assert case.rotor_speed == pytest.approx(2.0, rel=1e-6)
    wind = model.wind
    assert isinstance(wind.vertical, windfield.CubicShear)
    # the paper counts y to the right looking downwind
    assert (wind.speed, wind.vertical.exponent, wind.horizontal_shear) == (15.0, 0.2, -5e-4)
    assert not wind.tower.lateral
    task = case.task()
    assert task.positions == 24
    assert task.weights == LoadWeights.unit()
    assert task.blade_cap is None
    assert task.limits.pitch_rate == pytest.approx(np.deg2rad(10.0))


def test_real_turbines_have_the_physical_defaults():
    case = load_case("nrel-5mw")
    model, task = case.model(), case.task()
    assert model.induction == "equilibrium"
    assert model.pitch_rate_terms
    assert model.radial_moment
    assert isinstance(model.wind.vertical, windfield.PowerLaw)
    assert model.wind.vertical.exponent == 0.2
    assert model.wind.tower.lateral
    assert np.rad2deg(model.rotor.tilt) == pytest.approx(5.0)
    assert task.weights == LoadWeights.tower_base(90.0)
    assert task.blade_cap == 1.0
    assert task.limits.pitch_rate == pytest.approx(np.deg2rad(8.0))


def test_default_wind_is_below_rated_for_the_catalogue():
    for name in set(names()) - {"biegel2011"}:
        rated = load_turbine(name).rated_wind_speed
        assert rated is None or WindSettings().speed < rated


@pytest.mark.parametrize(("speed", "rpm"), [(2.0, 6.9), (8.0, None), (20.0, 12.1)])
def test_rotor_speed_follows_the_schedule(speed, rpm):
    turbine = load_turbine("nrel-5mw")
    if rpm is None:
        rpm = turbine.optimal_tip_speed_ratio * speed / turbine.rotor.radius / RPM
    case = Case(name="x", turbine="nrel-5mw", wind=WindSettings(speed=speed))
    assert case.rotor_speed / RPM == pytest.approx(rpm)


def test_given_values_win_over_the_turbine():
    case = Case(
        name="x",
        turbine="nrel-5mw",
        operation=OperationSettings(rotor_speed=1.0, air_density=1.1, yaw=0.1),
        aero=AeroSettings(elements=7, alpha_min=-0.1, alpha_max=0.15, induction="none"),
        limits=LimitSettings(positions=5, pitch_min=-0.05, pitch_max=0.5, pitch_rate=0.05),
        objective=ObjectiveSettings(
            weights=LoadWeights(torque=2.0), blade_cap=None, harmonics=3, travel=10.0
        ),
    )
    model, task = case.model(), case.task()
    assert (model.rotor_speed, model.air_density, model.yaw) == (1.0, 1.1, 0.1)
    assert model.rotor.blade.span.size == 7
    assert model.alpha_limits == (-0.1, 0.15)
    assert model.pitch_range == (-0.05, 0.5)
    assert (task.limits.lower, task.limits.upper, task.limits.pitch_rate) == (-0.05, 0.5, 0.05)
    assert (task.positions, task.harmonics, task.travel, task.blade_cap) == (5, 3, 10.0, None)
    assert task.weights.torque == 2.0


def test_elements_of_the_papers_blade_follow_its_design_law():
    case = load_case("biegel2011").with_values({"aero.elements": 10})
    blade = case.rotor().blade
    assert blade.span.size == 10
    radius = 8.0 + blade.span
    expected = np.arctan(15 / (2 * radius)) - np.arctan(15 / (2 * 40))
    assert blade.twist == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    ("shear", "law"),
    [
        ("power", windfield.PowerLaw),
        ("cubic", windfield.CubicShear),
        ("log", windfield.LogLaw),
        ("none", type(None)),
    ],
)
def test_shear_laws(shear, law):
    case = Case(name="x", turbine="nrel-5mw", wind=WindSettings(shear=shear))
    assert isinstance(case.wind_field().vertical, law)


def test_disc_file(tmp_path):
    sample = windfield.sample_disc(load_case("nrel-5mw").wind_field(), 80.0, rings=5, azimuths=24)
    sample.to_csv(tmp_path / "disc.csv")
    case = Case(name="x", turbine="nrel-5mw", wind=WindSettings(disc=tmp_path / "disc.csv"))
    assert isinstance(case.wind_field(), windfield.DiscField)
    missing = case.with_values({"wind.disc": tmp_path / "none.csv"})
    with pytest.raises(InputError, match=r"^wind: .*none\.csv"):
        missing.wind_field()


def test_wind_that_does_not_fit_the_turbine_is_our_own_error():
    case = Case(
        name="x", turbine="nrel-5mw", wind=WindSettings(shear="log", roughness_length=100.0)
    )
    with pytest.raises(InputError, match=r"^wind: roughness_length: got 100"):
        case.task()


def test_settings_are_plain_and_complete():
    case = Case(name="x", turbine="nrel-5mw", wind=WindSettings(speed=9.0))
    settings = case.settings()
    assert settings["wind"]["speed"] == 9.0
    assert settings["operation"]["rotor_speed_rpm"] == pytest.approx(case.rotor_speed / RPM)
    assert settings["operation"]["air_density"] == 1.225
    assert settings["limits"]["pitch_rate_deg"] == 8.0
    assert settings["limits"]["pitch_max_deg"] == 90.0
    assert settings["objective"]["weights_name"] == "tower-base"
    assert settings["objective"]["weights"]["thrust"] == 90.0


def test_a_table_of_curves_is_a_model(table):
    case = Case(
        name="t",
        curves=table,
        operation=OperationSettings(rotor_speed=1.2),
        objective=ObjectiveSettings(weights="unit"),
    )
    task = case.task()
    assert (task.positions, case.blades) == (3, 3)
    assert np.rad2deg([task.limits.lower, task.limits.upper]) == pytest.approx([-2.0, 8.0])
    assert task.limits.pitch_rate == pytest.approx(np.deg2rad(8.0))
    assert case.settings()["limits"]["positions"] == 3


def test_a_table_with_a_turbine_takes_its_limits_and_hub_height(table):
    task = Case(name="t", turbine="nrel-5mw", curves=table).task()
    assert task.positions == 3
    assert task.weights.thrust == 90.0
    assert task.limits.lower == pytest.approx(0.0)


def test_a_table_alone_needs_rotor_speed_and_own_weights(table):
    with pytest.raises(InputError, match=r"^operation\.rotor_speed_rpm: got 'auto'"):
        Case(name="t", curves=table).task()
    case = Case(name="t", curves=table, operation=OperationSettings(rotor_speed=1.2))
    with pytest.raises(InputError, match=r"^objective\.weights: got 'tower-base'"):
        case.task()
    with pytest.raises(InputError, match="a table of curves has no wind"):
        case.wind_field()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Case(name="x"), "^turbine: got nothing"),
        (lambda: Case(name="", turbine="nrel-5mw"), "^name: got ''"),
        (lambda: Case(name="x", turbine="nrel-5mw", wind={}), "^wind: got dict"),
        (lambda: WindSettings(speed=-1.0), r"^wind\.speed: got -1\.0"),
        (lambda: WindSettings(shear="linear"), r"^wind\.shear: got 'linear'"),
        (lambda: OperationSettings(air_density=-1.2), r"^operation\.air_density: got -1\.2"),
        (lambda: AeroSettings(segments=0), r"^aero\.segments: got 0"),
        (lambda: AeroSettings(elements=0), r"^aero\.elements: got 0"),
        (lambda: LimitSettings(positions=0), r"^limits\.positions: got 0"),
        (lambda: LimitSettings(pitch_min=0.2, pitch_max=0.1), r"^limits\.pitch_min_deg, limits"),
        (lambda: AeroSettings(alpha_min=0.2, alpha_max=0.1), r"^aero\.alpha_min_deg, aero"),
        (lambda: ObjectiveSettings(blade_cap=0.0), r"^objective\.blade_cap: got 0"),
        (lambda: ObjectiveSettings(travel=np.nan), r"^objective\.travel: got nan"),
    ],
)
def test_bad_values_are_found_at_construction(build, message):
    with pytest.raises(InputError, match=message):
        build()


def test_a_given_limit_may_cross_the_turbines():
    case = Case(name="x", turbine="nrel-5mw", limits=LimitSettings(pitch_max=-0.1))
    with pytest.raises(InputError, match=r"^limits\.pitch_min_deg, .*got 0 and -5\.7"):
        case.task()
