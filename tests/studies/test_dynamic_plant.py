"""The dynamic turbine as a plant: the static rotor as its limit, averages, seams, going on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ilc import Plant, StatefulPlant
from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.cases import Case, load_case
from pitchopt.control import PitchActuator, nrel_5mw_baseline
from pitchopt.errors import ComputationError, InputError
from pitchopt.sim import DynamicTurbine, Start
from pitchopt.studies.learning import DynamicPlant, TurbineSettings, TurbineSetup
from pitchopt.studies.learning.dynamic_plant import whole_step
from pitchopt.studies.learning.turbine_study import turned_profile

M = 12
PITCH = float(np.deg2rad(2.0))


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("nrel-5mw").with_values({"wind.speed": 9.0, "limits.positions": M})


@pytest.fixture(scope="module")
def make(case: Case) -> Callable[..., DynamicPlant]:
    """A plant with everything locked and no weight, or other parameters."""

    def call(
        *, pitch: float = PITCH, warm_up: int = 2, averaged: int = 0, **changes: object
    ) -> DynamicPlant:
        given: dict = {
            "freedoms": (),
            "inflow": "quasi-steady",
            "gravity": False,
            "step": whole_step(case.rotor_speed, 3 * M, 0.02),
        }
        return DynamicPlant(
            DynamicTurbine(turbine=case.turbine_data, **given | changes),
            case.wind_field(),
            positions=M,
            start=Start(rotor_speed=case.rotor_speed, pitch=pitch),
            averaged=averaged,
            warm_up=warm_up,
        )

    return call


def interval_means(case: Case, profile: np.ndarray, fine: int = 24) -> np.ndarray:
    """Static rotor loads (4, m), mean over the interval about each position.

    Each blade's pitch is linear between its stations, half a station late, as the plant plays it.
    """
    model = case.model()
    assert isinstance(model, StaticRotor)
    stations = 3 * M
    offset = (np.arange(fine) + 0.5) / fine - 0.5
    place = (np.arange(stations)[:, None] + offset).ravel()  # in stations
    pitch = np.interp(place - 0.5, np.arange(-1, stations + 1), np.pad(profile, 1, mode="wrap"))
    slope = np.diff(np.pad(profile, (1, 0), mode="wrap"))  # from station n - 1 to n
    rate = slope[np.floor(place + 0.5).astype(int) % stations] * stations / (2 * np.pi)
    psi = 2 * np.pi * place / stations
    blade = model.blade_loads(psi, pitch, rate * case.rotor_speed)
    tilt = blade.bending * np.cos(psi) - blade.radial * np.sin(psi)
    yaw = blade.bending * np.sin(psi) + blade.radial * np.cos(psi)
    one = np.array([blade.torque, tilt, yaw, blade.thrust])
    return np.asarray(one.reshape(4, 3, M, fine).mean(axis=3).sum(axis=1))


# ---- the static rotor as the limit ---------------------------------------------------------


@pytest.mark.parametrize("move", [0.0, 1.0])
@pytest.mark.parametrize("skew", [False, True])
def test_locked_turbine_has_the_static_rotors_equilibrium_loads(case, make, skew, move):
    case = case.with_values({"aero.skew": skew})
    psi = 2 * np.pi * np.arange(3 * M) / (3 * M)
    profile = PITCH + np.deg2rad(move) * np.cos(psi - 0.4)
    plant = make(step=whole_step(case.rotor_speed, 3 * M, 0.006), skew=skew)
    loads = plant.held(profile, 2)[-1, -1]
    expected = interval_means(case, profile)
    swing = np.ptp(expected, axis=1)
    assert np.all(np.abs(loads - expected) < 1e-3 * swing[:, None])


def test_gravity_adds_what_the_shaft_carries_and_nothing_periodic(make, case):
    with_weight, without = (make(gravity=gravity).warm_loads[-1, -1] for gravity in (True, False))
    difference = (with_weight - without).mean(axis=1)
    turbine = case.turbine_data
    mass = turbine.hub.mass + 3 * DynamicTurbine(turbine=turbine).blade.mass
    tilt = turbine.rotor.tilt
    assert abs(difference[3]) == pytest.approx(9.80665 * mass * np.sin(abs(tilt)), rel=1e-3)
    np.testing.assert_allclose(with_weight.std(axis=1), without.std(axis=1), rtol=1e-6)


# ---- passages ------------------------------------------------------------------------------


def test_plants_keep_the_protocols(make):
    plant = make()
    assert isinstance(plant, Plant)
    assert isinstance(plant, StatefulPlant)
    assert (plant.blades, plant.positions, plant.stations) == (3, M, 3 * M)


def test_a_passage_takes_a_third_of_a_turn_whatever_the_step(case, make):
    turn = 2 * np.pi / case.rotor_speed
    for step in (0.02, 0.0311):  # the second does not fit between the stations
        plant = make(step=step)
        before = plant.time
        plant.held(np.full(3 * M, PITCH), 3)
        assert plant.time - before == pytest.approx(3 * turn, abs=1.01 * step)


def test_blades_alike_give_the_loads_of_one_profile_and_others_do_not(make):
    psi = 2 * np.pi * np.arange(3 * M) / (3 * M)
    profile = PITCH + 0.01 * np.sin(psi)
    one, three, other = make(), make(), make()
    loads = one.held(profile, 2)
    np.testing.assert_array_equal(loads, three.held(np.tile(profile, (3, 1)), 2))
    own = np.tile(profile, (3, 1))
    own[0] += 0.01
    assert not np.allclose(loads, other.held(own, 2), rtol=1e-3)
    # each blade has its own profile at its own azimuth: all passages alike with one profile alone
    np.testing.assert_allclose(loads[-1, 0], loads[-1, 1], rtol=1e-5, atol=1.0)


def test_a_profile_at_the_rate_limit_is_no_controller_that_hunts(case, make):
    station = 2 * np.pi / (3 * M)
    place = np.arange(3 * M)
    zigzag = np.abs(place % M - M / 2)  # up and down by one a station, all blades alike
    swing = 0.999 * case.pitch_limits.pitch_rate * station / case.rotor_speed
    loads = make().held(PITCH + swing * (zigzag - zigzag.mean()), 12)  # 70 s
    np.testing.assert_allclose(loads[-1], loads[-2], rtol=1e-4, atol=1.0)


def test_pitch_goes_from_the_last_station_of_one_profile_to_the_first_of_the_next(make):
    first = PITCH + 0.002 * np.arange(3 * M) / M
    second = first + 0.01
    plant = make()
    plant.passage(first, 0)
    plant.passage(second, 1)
    # blade b has passed section (b + 1) mod B, half a station late: its last station exactly
    pitch = plant.pitch
    expected = [second[((b + 1) % 3) * M + M - 1] for b in range(3)]
    np.testing.assert_allclose(pitch, expected, atol=1e-12)


def test_averaged_passage_is_the_mean_over_whole_rotations(make):
    psi = 2 * np.pi * np.arange(3 * M) / (3 * M)
    profile = PITCH + 0.01 * np.cos(psi)
    free = ("blade-flap", "blade-edge", "tower-side-side")
    single, mean = make(freedoms=free), make(freedoms=free, averaged=2)
    got = [mean.passage(profile, j) for j in range(2)]
    turns = [single.passage(profile, j) for j in range(14)]
    assert mean.turns == 7
    np.testing.assert_allclose(got[0], np.mean(turns[1:7], axis=0), rtol=1e-13)
    np.testing.assert_allclose(got[1], np.mean(turns[8:14], axis=0), rtol=1e-13)
    with pytest.raises(InputError, match="averages over 2 rotations"):
        mean.held(profile, 1)


def test_controlled_rotor_takes_back_a_change_of_the_mean_pitch():
    case = load_case("nrel-5mw").with_values({"wind.speed": 16.0, "limits.positions": M})
    setup = TurbineSetup(case, TurbineSettings(rotor="controlled", structure="rigid"), 0.0)
    plant = setup.plant()
    start = setup.start.pitch
    before = plant.pitch.mean()
    loads = plant.held(np.full(3 * M, start + np.deg2rad(1.0)), 30)
    assert plant.pitch.mean() == pytest.approx(before, abs=np.deg2rad(0.05))
    assert loads[-1, :, 0].mean() == pytest.approx(setup.mean_torque, rel=1e-3)
    assert plant.rotor_speed == pytest.approx(setup.rotor_speed, rel=0.01)


# ---- lag -----------------------------------------------------------------------------------


def test_lag_is_half_a_station_and_what_actuators_and_blades_add(case):
    def angle(**changes: object) -> float:
        return TurbineSetup(case, TurbineSettings(**changes), PITCH).lag.angle

    rigid = angle(structure="rigid")
    slow = angle(structure="rigid", pitch_lag=0.1)
    # first order: atan(omega tau) at once per turn; the command of a step's end is held over it
    step = TurbineSetup(case, TurbineSettings(), PITCH).dynamic.step
    expected = np.arctan(0.1 * case.rotor_speed) - 0.5 * case.rotor_speed * step
    assert slow - rigid == pytest.approx(expected, rel=0.03)
    assert 0 < rigid < np.pi / (3 * M)
    setup = TurbineSetup(case, TurbineSettings(), PITCH)
    assert setup.lag.angle > rigid + np.deg2rad(10)
    assert setup.lag.samples == np.ceil(setup.lag.angle / (2 * np.pi / (3 * M)))


def test_turned_profile_is_the_profile_earlier():
    psi = 2 * np.pi * np.arange(30) / 30
    profile = 0.1 + 0.02 * np.cos(psi - 0.3) + 0.01 * np.sin(3 * psi)
    turned = turned_profile(profile, 0.2)
    expected = 0.1 + 0.02 * np.cos(psi - 0.1) + 0.01 * np.sin(3 * (psi + 0.2))
    np.testing.assert_allclose(turned, expected, atol=1e-15)


# ---- going on ------------------------------------------------------------------------------


@pytest.mark.parametrize("rotor", ["held", "controlled"])
def test_goes_on_from_a_state_to_the_last_bit(rotor):
    case = load_case("nrel-5mw").with_values({"wind.speed": 16.0, "limits.positions": M})
    setup = TurbineSetup(case, TurbineSettings(rotor=rotor, turbulence="B"), np.deg2rad(8.0))
    psi = 2 * np.pi * np.arange(3 * M) / (3 * M)
    profiles = [setup.start.pitch + 0.005 * np.cos(psi + j) for j in range(9)]
    plant, other = setup.plant(7), setup.plant(7)
    for j in range(4):
        plant.passage(profiles[j], j)
    state = plant.state()
    rest = [plant.passage(profiles[j], j) for j in range(4, 9)]
    other.restore(state)
    assert other.passages == 4
    again = [other.passage(profiles[j], j) for j in range(4, 9)]
    np.testing.assert_array_equal(rest, again)
    # and a plant of its own kind without the state is elsewhere
    assert not np.allclose(
        setup.plant(8).passage(profiles[0], 0), setup.plant(7).passage(profiles[0], 0)
    )


def test_foreign_states_are_refused_and_change_nothing(make):
    plant = make()
    state = plant.state()
    for name in ("carry", "run.q"):
        with pytest.raises(InputError, match="missing or of another shape"):
            plant.restore({key: value for key, value in state.items() if key != name})
    again, fresh = plant.passage(np.full(3 * M, PITCH), 0), make().passage(np.full(3 * M, PITCH), 0)
    np.testing.assert_array_equal(again, fresh)


# ---- input ---------------------------------------------------------------------------------


def test_bad_input(case, make):
    plant = make()
    good = np.full(3 * M, PITCH)
    with pytest.raises(InputError, match=r"profile: got shape \(5,\), expected \(36,\) or"):
        plant.passage(good[:5], 0)
    with pytest.raises(InputError, match="profile"):
        plant.passage(np.full(3 * M, np.nan), 0)
    with pytest.raises(InputError, match="number: got 3, expected 0"):
        plant.passage(good, 3)
    with pytest.raises(InputError, match="controller: got none with a rotor whose speed is free"):
        make(freedoms=("rotor-speed",))
    with pytest.raises(InputError, match=r"step: got 0\.2 s, in which the rotor turns by"):
        make(step=0.2)
    dynamic = DynamicTurbine(turbine=case.turbine_data, freedoms=())
    with pytest.raises(InputError, match="controller: got one with a rotor whose speed is held"):
        DynamicPlant(
            dynamic,
            case.wind_field(),
            positions=M,
            start=Start(rotor_speed=1.0),
            controller=nrel_5mw_baseline(),
        )


def test_divergence_is_an_error_that_says_when(case):
    free = Start(rotor_speed=1.9 * case.turbine_data.rated_rotor_speed, pitch=0.0, torque=0.0)
    high = DynamicTurbine(
        turbine=case.turbine_data,
        freedoms=("rotor-speed",),
        step=0.02,
        actuator=PitchActuator(lowest=0.0, highest=1e-6, rate=0.1),
    )
    with pytest.raises(ComputationError, match=r"diverged at .* s in passage"):
        DynamicPlant(
            high,
            case.with_values({"wind.speed": 25.0}).wind_field(),
            positions=4,
            start=free,
            controller=nrel_5mw_baseline(),
        )


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"turbulence": "D"}, "turbulence: got 'D', expected one of none, A"),
        ({"structure": "soft"}, "structure: got 'soft'"),
        ({"rotor": "free"}, "rotor: got 'free'"),
        ({"averaged": -1}, "averaged"),
        ({"pitch_lag": -0.1}, "pitch_lag"),
    ],
)
def test_bad_settings(values, text):
    with pytest.raises(InputError, match=text):
        TurbineSettings(**values)


def test_turbines_without_structure_are_one_clear_error():
    with pytest.raises(InputError, match="'biegel2011': blade structure, hub, nacelle not known"):
        TurbineSetup(load_case("biegel2011"), TurbineSettings(), 0.0)
