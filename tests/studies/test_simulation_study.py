"""Simulated runs: winds, controllers by name and from files, statistics, sums, threads."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.aero.steady import UniformInflow
from pitchopt.control import LinearQuadratic, PitchActuator
from pitchopt.errors import InputError
from pitchopt.exports import profile_csv
from pitchopt.sim import DynamicTurbine, Operation, average
from pitchopt.studies.simulation import (
    SimulationSettings,
    controller_from_table,
    individual_pitch,
    load_controller,
    named_controller,
    run_simulations,
    selected_channels,
    simulation_document,
    wind_cases,
)
from pitchopt.turbines import load_turbine
from windfield import (
    BoxCache,
    PowerLaw,
    StaticField,
    TurbulentField,
    WindFieldError,
    kaimal_box,
    write_bts,
)

RUNAWAY = {
    "torque": {"factor": 0.01},
    "pitch": {"proportional": 0, "integral": 1e-9},
}


@pytest.fixture(scope="module")
def dynamic():
    return DynamicTurbine(turbine=load_turbine("nrel-5mw"), step=0.05)


@pytest.fixture(scope="module")
def operation(dynamic):
    return Operation(dynamic)


def steady(speed: float, **changes) -> SimulationSettings:
    given = {
        "wind_speeds": (speed,), "turbulence": "none", "duration": 10.0, "skip": 0.0,
        "channels": ("GenPwr", "RotSpeed"),
    }  # fmt: skip
    return SimulationSettings(**{**given, **changes})


def rotation_amplitude(series, skip):
    """Amplitude of RootMyc1 at the rotor's frequency."""
    rows = series.time >= skip
    psi = np.deg2rad(series["Azimuth"][rows])
    basis = [np.ones(psi.size)]
    basis += [f(n * psi) for n in (1, 2, 3) for f in (np.cos, np.sin)]
    fit = np.linalg.lstsq(np.column_stack(basis), series["RootMyc1"][rows], rcond=None)[0]
    return math.hypot(fit[1], fit[2])


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.0, 0.4])
def test_individual_pitch_takes_out_the_rotors_frequency(dynamic, lag):
    """In sheared wind, with and without lag of the actuators."""
    low, high = dynamic.turbine.pitch_range
    actuator = PitchActuator(
        lowest=low, highest=high, rate=dynamic.turbine.pitch_rate, time_constant=lag or None
    )
    lagging = dataclasses.replace(dynamic, actuator=actuator)
    operation = Operation(lagging)
    found = {}
    for name in ("baseline", "ipc"):
        settings = steady(16.0, skip=60.0, duration=40.0, channels=("Azimuth", "RootMyc1"))
        result = run_simulations(
            lagging, named_controller(operation, name), settings, operation=operation
        )
        found[name] = rotation_amplitude(result.runs[0].series, 60.0)
    assert found["baseline"] > 1000.0  # kN m
    assert found["ipc"] < 0.05 * found["baseline"]


def test_gain_of_individual_pitch(dynamic, operation):
    """Bandwidth of the loop where pitch tells most: a fifth of the rotor's speed."""
    individual = individual_pitch(operation)
    rotor, omega = dynamic.turbine.rotor, dynamic.turbine.rated_rotor_speed
    curve = operation.curve
    slopes = []
    for i in np.flatnonzero(curve.pitch > math.radians(0.5)):
        model = StaticRotor(
            rotor=rotor,
            wind=UniformInflow(float(curve.wind_speed[i])),
            rotor_speed=omega,
            air_density=dynamic.turbine.air_density,
            induction="frozen",
        )
        pitch, step = float(curve.pitch[i]), math.radians(0.05)
        load = [
            model.blade_loads(0.0, pitch + s, mean_pitch=pitch).bending.mean()
            for s in (-step, step)
        ]
        slopes.append((load[0] - load[1]) / (2 * step))
    assert individual.gain[0] * max(slopes) == pytest.approx(0.2 * omega, rel=0.02)
    assert individual.fade_from == operation.fine_pitch


def test_statistics_leave_out_the_start(dynamic, operation):
    controller = operation.baseline()
    result = run_simulations(dynamic, controller, steady(9.0, skip=5.0, duration=10.0))
    (run,) = result.runs
    assert run.series.time[-1] == pytest.approx(15.0)
    late = run.series["GenPwr"][run.series.time >= 5.0 - 1e-9]
    assert run.statistics["GenPwr"].mean == pytest.approx(1e3 * late.mean(), rel=1e-12)
    assert run.statistics["GenPwr"].largest == pytest.approx(1e3 * late.max(), rel=1e-12)


def test_threads_and_cache_change_nothing(dynamic, operation, tmp_path):
    settings = SimulationSettings(
        wind_speeds=(10.0, 14.0), seeds=(1, 7), duration=10.0, skip=2.0, box_points=5,
        channels=("GenPwr", "TwrBsMyt"),
    )  # fmt: skip
    controller = operation.baseline()
    told = []
    one = run_simulations(dynamic, controller, settings, operation=operation,
                          progress=lambda *step: told.append(step))  # fmt: skip
    cache = BoxCache(tmp_path)
    two, three = (
        run_simulations(dynamic, controller, settings, operation=operation, workers=3, cache=cache)
        for _ in range(2)
    )
    assert told == [(n, 4, "simulation") for n in range(5)]
    assert len(list(tmp_path.iterdir())) == 4
    assert [(r.wind_speed, r.seed) for r in one.runs] == [(10, 1), (10, 7), (14, 1), (14, 7)]
    for a, b, c in zip(one.runs, two.runs, three.runs, strict=True):
        assert np.array_equal(a.series.values, b.series.values)
        assert np.array_equal(a.series.values, c.series.values)
    assert not np.array_equal(one.runs[0].series.values, one.runs[1].series.values)


def test_sums_over_seeds_and_wind_speeds(dynamic, operation):
    settings = SimulationSettings(
        wind_speeds=(8.0, 10.0, 12.0), seeds=(1, 2), duration=8.0, skip=2.0, box_points=4,
        channels=("GenPwr", "TwrBsMyt"),
    )  # fmt: skip
    result = run_simulations(dynamic, operation.baseline(), settings, operation=operation)
    middle = result.summary()[1]
    assert (middle.wind_speed, middle.runs, middle.diverged) == (10.0, 2, 0)
    assert middle.statistics == average([run.statistics for run in result.runs[2:4]])
    lifetime = result.lifetime()
    assert lifetime.mean_wind_speed == 10.0  # class IB
    # Rayleigh: exp(-pi/4 (v / mean)^2) from 7 to 13 m/s
    edge = np.exp(-math.pi / 4 * (np.array([7.0, 9.0, 11.0, 13.0]) / 10.0) ** 2)
    assert lifetime.share == pytest.approx(edge[0] - edge[-1])
    weights = -np.diff(edge) / (edge[0] - edge[-1])
    np.testing.assert_allclose(lifetime.weights, weights)
    loads = [speed.statistics["TwrBsMyt"].equivalent_load for speed in result.summary()]
    assert lifetime.equivalent_loads["TwrBsMyt"] == pytest.approx(
        (weights @ np.array(loads) ** 4) ** 0.25
    )
    powers = [speed.statistics["GenPwr"].mean for speed in result.summary()]
    assert lifetime.means["GenPwr"] == pytest.approx(weights @ powers)
    assert "GenPwr" not in lifetime.equivalent_loads
    other = dataclasses.replace(result, settings=dataclasses.replace(settings, weibull_mean=7.0))
    assert other.lifetime().mean_wind_speed == 7.0
    assert dataclasses.replace(result, iec_class=None).lifetime() is None


def test_run_that_diverges(dynamic, operation):
    """Ends with its time, statistics of what there was, and leaves the sums to the others."""
    controller = controller_from_table(RUNAWAY, operation)
    settings = SimulationSettings(
        wind_speeds=(11.0,), turbulence="0.5", seeds=(1, 2), duration=60.0, skip=20.0,
        channels=("GenPwr", "RotSpeed", "TwrBsMyt"),
    )  # fmt: skip
    result = run_simulations(dynamic, controller, settings, operation=operation)
    assert result.diverged
    late, early = sorted(result.runs, key=lambda run: -run.diverged_at)
    assert early.diverged_at < 20.0 < late.diverged_at < 80.0
    assert early.statistics is None
    assert late.statistics["RotSpeed"].largest < 2.1 * dynamic.turbine.rated_rotor_speed
    for run in result.runs:
        assert run.status == "diverged"
        assert np.isfinite(run.series.values).all()
        assert run.series.time[-1] <= run.diverged_at
    assert result.summary()[0].statistics is None
    assert result.lifetime() is None
    document = simulation_document(result, {})
    assert document["runs"][0]["status"] == "diverged"
    assert document["summary"][0]["diverged"] == 2


def test_wind_of_a_turbsim_file(dynamic, operation, tmp_path):
    box = kaimal_box(13.0, 20.0, 0.2, hub_height=90.0, width=140.0, points=(8, 8), seed=3)
    mean = StaticField(speed=13.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2))
    field = TurbulentField(mean=mean, box=box)
    path = tmp_path / "wind.bts"
    write_bts(path, field)
    settings = SimulationSettings(
        turbulence=str(path), duration=10.0, skip=5.0, tower_shadow=False,
        channels=("Wind1VelX", "GenPwr"),
    )  # fmt: skip
    result = run_simulations(dynamic, operation.baseline(), settings, operation=operation)
    (run,) = result.runs
    assert (run.wind_speed, run.seed) == (13.0, None)
    calm = dataclasses.replace(settings, turbulence="none", wind_speeds=(13.0,))
    direct = run_simulations(dynamic, operation.baseline(), calm, operation=operation)
    assert np.ptp(run.series["Wind1VelX"]) > 1.0 > np.ptp(direct.runs[0].series["Wind1VelX"])
    seen = field.velocity(0.0, 0.0, 90.0, run.series.time)[:, 0]  # at the tower axis, like there
    assert np.sqrt(np.mean((run.series["Wind1VelX"] - seen) ** 2)) < 0.05
    for changes, match in (
        ({"duration": 60.0}, "repeats after 20 s"),
        ({"shear": 0.1}, "holds its own"),
        ({"wind_speeds": (12.0,)}, "the file's own 13 m/s"),
        ({"wind_speeds": (13.0, 14.0)}, "the file's own 13 m/s"),
        ({"seeds": (1,)}, "the wind is given"),
    ):
        bad = dataclasses.replace(settings, **changes)
        with pytest.raises(InputError, match=match):
            run_simulations(dynamic, operation.baseline(), bad, operation=operation)
    narrow = kaimal_box(13.0, 20.0, 0.2, hub_height=90.0, width=120.0, points=(8, 8), seed=3)
    write_bts(path, TurbulentField(mean=mean, box=narrow))
    with pytest.raises(InputError, match="wind: "):
        run_simulations(dynamic, operation.baseline(), settings, operation=operation)
    low = StaticField(speed=13.0, hub_height=80.0, vertical=PowerLaw(exponent=0.2))
    write_bts(path, TurbulentField(mean=low, box=narrow))
    with pytest.raises(InputError, match="hub height of 90 m"):
        wind_cases(dynamic, settings)
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(WindFieldError, match="bytes"):
        wind_cases(dynamic, settings)


def test_wind_of_a_hawc2_box(dynamic, tmp_path):
    shape = (64, 8, 8)
    random = np.random.default_rng(0)
    parts = random.normal(size=(3, *shape)).astype("<f4")
    for name, part in zip("uvw", parts, strict=True):
        (tmp_path / f"box_{name}.bin").write_bytes(part.tobytes())
    settings = SimulationSettings(
        wind_speeds=(8.0, 12.0), turbulence=str(tmp_path / "box_u.bin"), duration=10.0, skip=1.0,
        box_shape=shape, box_spacing=(4.0, 20.0, 20.0),
    )  # fmt: skip
    cases = wind_cases(dynamic, settings)
    assert [(case.wind_speed, case.seed) for case in cases] == [(8.0, None), (12.0, None)]
    for case in cases:
        field = case.make()
        # slice 3 at the tower axis, leftmost column of the file at y = 70 m
        speed = field.velocity(0.0, 70.0, 90.0 + 10.0, 3 * 4.0 / case.wind_speed)[0]
        mean = case.mean.velocity(0.0, 70.0, 100.0)[0]
        assert speed - mean == pytest.approx(parts[0, 3, 0, 4], abs=1e-5)
    prefix = dataclasses.replace(settings, turbulence=str(tmp_path / "box"))
    assert len(wind_cases(dynamic, prefix)) == 2
    with pytest.raises(InputError, match="box_shape"):
        wind_cases(dynamic, dataclasses.replace(settings, box_shape=None, box_spacing=None))
    with pytest.raises(InputError, match="HAWC2"):
        wind_cases(dynamic, dataclasses.replace(settings, turbulence="B"))
    with pytest.raises(WindFieldError, match="bytes"):
        wind_cases(dynamic, dataclasses.replace(settings, box_shape=(32, 8, 8)))


def test_kaimal_box_reaches_beyond_the_blades(dynamic):
    for turbine in (dynamic, DynamicTurbine(turbine=load_turbine("iea-22-280"))):
        settings = SimulationSettings(duration=10.0, skip=5.0, box_points=4)
        (case,) = wind_cases(turbine, settings)
        box, reach = case.make().box, turbine.reach
        assert box.y[-1] > reach.half_width and box.y[-1] < 1.05 * reach.half_width
        assert box.z[0] <= reach.low and box.z[-1] >= reach.high
        assert box.duration >= 15.0
        assert "class B" in case.turbulence


def test_channels(dynamic):
    assert [c.name for c in selected_channels(dynamic, ("GenPwr", "Azimuth", "GenPwr"))] == [
        "GenPwr", "Azimuth",
    ]  # fmt: skip
    assert {"GenPwr", "RootMyc3", "TwrBsMyt"} < {c.name for c in selected_channels(dynamic)}
    assert selected_channels(dynamic, ("all",)) == dynamic.channels[1:]
    with pytest.raises(InputError, match="did you mean 'RootMyc"):
        selected_channels(dynamic, ("RootMyc",))


def test_controllers_by_name(operation):
    assert named_controller(operation, "baseline").pitch.reference_speed == 122.9096
    tuned = named_controller(operation, "tuned")
    assert tuned.pitch == operation.pitch_regulator()
    assert isinstance(named_controller(operation, "lqr").pitch, LinearQuadratic)
    with pytest.raises(InputError, match="expected one of"):
        named_controller(operation, "none")
    with pytest.raises(InputError, match="did you mean 'tuned'"):
        load_controller("tund", operation)


def test_controller_file(operation, tmp_path):
    psi = 2 * np.pi * np.arange(24) / 24
    profile = 0.02 + 0.03 * np.cos(psi) - 0.01 * np.sin(2 * psi)
    (tmp_path / "profile.csv").write_text(profile_csv(psi, profile, rotor_speed=1.2))
    path = tmp_path / "own.toml"
    path.write_text(
        """
        base = "baseline"
        [torque]
        factor = 0.8
        constant_power = false
        [pitch]
        proportional = 0.01
        reference_rpm = 1150
        [minimum_pitch]
        wind_speed = [8, 11, 14]
        pitch_deg = [0, 3, 0]
        [individual]
        harmonics = [1, 2]
        gain = [2e-9, 1e-9]
        offset_deg = [20, 10]
        amplitude_deg = 4
        fade_from_deg = 1
        fade_to_deg = 4
        fade_time = 30
        [feedforward]
        profile = "profile.csv"
        harmonics = 2
        time_constant = 0.4
        wind_speed = [11, 13]
        scale = [0, 1]
        """
    )
    own = load_controller(path, operation)
    base = operation.baseline()
    assert (own.torque.factor, own.torque.constant_power) == (0.8, False)
    assert own.torque.gain == base.torque.gain
    assert (own.pitch.proportional, own.pitch.integral) == (0.01, base.pitch.integral)
    assert own.pitch.reference_speed == pytest.approx(1150 * math.pi / 30)
    assert float(own.minimum_pitch.lowest(11.0)) == pytest.approx(math.radians(3))
    individual = own.individual
    assert individual.order.tolist() == [1, 2] and individual.gain.tolist() == [2e-9, 1e-9]
    np.testing.assert_allclose(np.degrees(individual.offset), [20, 10])
    np.testing.assert_allclose(np.degrees(individual.limit), [4, 4])
    assert math.degrees(individual.fade_to) == pytest.approx(4)
    assert individual.fade_time == 30
    np.testing.assert_allclose(own.feedforward.deviation(psi), profile - profile.mean(), atol=1e-12)
    assert own.feedforward.time_constant == 0.4 and own.feedforward.over_wind
    assert own.estimator is not None


def test_parts_of_a_controller_from_a_table(operation):
    plain = controller_from_table({}, operation)
    assert plain.pitch == operation.pitch_regulator() and plain.estimator is None
    slow = controller_from_table({"pitch": {"frequency": 0.3, "damping": 1.0}}, operation)
    assert slow.pitch == operation.pitch_regulator(frequency=0.3, damping=1.0)
    harmonics = {"feedforward": {"cosine_deg": [1.0], "sine_deg": [2.0]}}
    assert math.degrees(controller_from_table(harmonics, operation).feedforward.sine[0]) == (
        pytest.approx(2.0)
    )
    damped = controller_from_table({"base": "lqr", "lqr": {"tower_velocity": 0.2}}, operation)
    bare = controller_from_table({"base": "lqr"}, operation)
    assert not np.allclose(damped.pitch.gains, bare.pitch.gains)


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ({"pitch": {"frequncy": 1.0}}, "pitch.frequncy: unknown key.*did you mean 'frequency'"),
        ({"pich": {}}, "pich: unknown key.*did you mean 'pitch'"),
        ({"pitch": 3}, r"expected a section \[pitch\]"),
        ({"pitch": {"frequency": "x"}}, "pitch.frequency: got 'x'"),
        ({"pitch": {"frequency": 0.5, "integral": 1.0}}, "together with frequency"),
        ({"pitch": {"linear": -9.0}}, "changed sign"),
        ({"base": "ipc"}, "base: got 'ipc', expected one of baseline, tuned, lqr"),
        ({"lqr": {"tower_velocity": 0.1}}, "base = 'lqr'"),
        ({"base": "lqr", "pitch": {"damping": 1.0}}, "gains are its own"),
        ({"torque": {"factor": 0}}, "torque.factor"),
        ({"minimum_pitch": {"wind_speed": [8, 9]}}, "minimum_pitch.pitch_deg: got nothing"),
        ({"minimum_pitch": {"wind_speed": [9, 8], "pitch_deg": [0, 1]}}, "minimum_pitch.wind_sp"),
        ({"individual": {"harmonics": [1]}}, "individual.gain: got nothing"),
        ({"individual": {"gain": [1e-9] * 3}}, "individual.harmonics: .*three"),
        ({"individual": {"gain": [1e-9], "harmonics": [0]}}, "individual.harmonics: got 0.0"),
        (
            {"minimum_pitch": {"wind_speed": [8, 9], "pitch_deg": [0, 300]}},
            "minimum_pitch.pitch_deg: got 300, expected angles that the pitch actuators reach",
        ),
        ({"minimum_pitch": {"wind_speed": [8, 9], "pitch_deg": [0]}}, "minimum_pitch.pitch_deg:"),
        ({"feedforward": {"cosine_deg": [1], "sine_deg": [0, 1]}}, "feedforward.sine_deg: got sh"),
        ({"individual": {"gain": []}}, "individual.gain: got"),
        ({"individual": {"gain": ["a"]}}, "individual.gain: got 'a'"),
        ({"feedforward": {}}, "neither of profile and cosine_deg"),
        ({"feedforward": {"cosine_deg": [1], "profile": "a.csv"}}, "profile and cosine_deg"),
        ({"feedforward": {"cosine_deg": [1], "point": "knee"}}, "feedforward.point"),
        ({"feedforward": {"profile": "a.csv", "sine_deg": [1]}}, "sine_deg"),
        ({"feedforward": {"profile": "a.csv", "point": "knee"}}, "expected an .npz file"),
        ({"feedforward": {"profile": "absent.npz"}}, "no such file"),
        ({"feedforward": {"cosine_deg": [1], "scale": [1]}}, "feedforward.wind_speed: got nothing"),
    ],
)
def test_bad_controller_table(operation, table, match):
    with pytest.raises(InputError, match=match):
        controller_from_table(table, operation)


def test_profile_that_is_no_whole_turn(operation, tmp_path):
    psi = np.linspace(0.1, 3.0, 24)
    (tmp_path / "half.csv").write_text(profile_csv(psi, 0.01 * np.cos(psi), rotor_speed=1.2))
    with pytest.raises(InputError, match="evenly spaced ones of a whole turn"):
        controller_from_table({"feedforward": {"profile": "half.csv"}}, operation, folder=tmp_path)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"wind_speeds": (8.0, 8.0)}, "wind_speeds: got 8, 8"),
        ({"wind_speeds": (0.0,)}, "wind_speeds"),
        ({"seeds": (1, 1)}, "seeds"),
        ({"seeds": ()}, "seeds"),
        ({"seeds": (-1,)}, "seeds"),
        ({"duration": 0.0}, "duration: got 0 s, expected at least two intervals"),
        ({"duration": 10.0, "interval": 8.0}, "two intervals of the series, 16 s"),
        ({"skip": -1.0}, "skip"),
        ({"shear": 2.0}, "shear"),
        ({"box_shape": (8, 8, 8)}, "expected both"),
        ({"weibull_mean": 0.0}, "weibull_mean"),
    ],
)
def test_bad_settings(changes, match):
    with pytest.raises(InputError, match=match):
        SimulationSettings(**changes)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"turbulence": "D"}, "expected one of A\\+"),
        ({"turbulence": "1.5"}, "intensity"),
        ({"turbulence": "none", "seeds": (1,)}, "the wind is given"),
        ({"wind_speeds": (2.0,)}, "cut-in at 3"),
        ({"wind_speeds": (12.0, 26.0)}, "cut-out at 25"),
    ],
)
def test_bad_wind(dynamic, operation, changes, match):
    with pytest.raises(InputError, match=match):
        run_simulations(dynamic, operation.baseline(), SimulationSettings(**changes))
