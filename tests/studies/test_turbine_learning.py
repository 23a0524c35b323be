"""Learning on the dynamic turbine: what the learner gains, twins, checkpoints, input."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.cases import Case, load_case
from pitchopt.errors import InputError
from pitchopt.exports.records import plain
from pitchopt.studies.learning import (
    BladeDifference,
    ConstantWind,
    LearningSettings,
    Reference,
    TurbineLearning,
    TurbineSettings,
    WindTasks,
    learn_on_turbine,
    reference,
)
from pitchopt.studies.learning.turbine_study import HeldLoads, rotation_rms

pytestmark = pytest.mark.slow

M = 12
LOSS = 0.03


class StopError(Exception):
    """Ends a run from its progress."""


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("nrel-5mw").with_values({"wind.speed": 9.0, "limits.positions": M})


@pytest.fixture(scope="module")
def known(case) -> Reference:
    return reference(WindTasks(case=case), max_power_loss=LOSS)


@pytest.fixture(scope="module")
def windy() -> Case:
    return load_case("nrel-5mw").with_values({"wind.speed": 16.0, "limits.positions": M})


@pytest.fixture(scope="module")
def windy_known(windy) -> Reference:
    return reference(WindTasks(case=windy), max_power_loss=LOSS)


def learnt(
    case: Case, known: Reference | None, rotations: int = 12, **turbine: object
) -> TurbineLearning:
    return learn_on_turbine(
        case,
        LearningSettings(rotations=rotations, max_power_loss=LOSS),
        TurbineSettings(**turbine),
        known=known,
        judged=8,
        seeds=1,
    )


@pytest.fixture(scope="module")
def flexible(case, known) -> TurbineLearning:
    return learnt(case, known)


def test_steady_wind_with_structure_locked_and_free(case, known, flexible):
    rigid = learnt(case, known, structure="rigid")
    assert rigid.setup.lag.samples == 1
    assert flexible.setup.lag.samples == 2
    for result, most in ((rigid, 0.12), (flexible, 0.3)):
        assert result.left(10, 12) < most
        # and held, on a fresh plant, the profile does what it did in the run
        assert result.share(result.learned, "total") < most
        assert result.learned.mean[0] == pytest.approx(result.setpoint, rel=0.005)
        pitch = result.record.learning.profile
        station = 2 * np.pi / (3 * M) / result.setup.rotor_speed
        rate = np.abs(np.diff(pitch, axis=1, append=pitch[:, :1])).max() / station
        assert rate <= case.pitch_limits.pitch_rate * (1 + 1e-9)


def test_without_the_lag_the_learner_does_not_converge(case, known, flexible, monkeypatch):
    import pitchopt.studies.learning.turbine_study as module

    original = module.learner_of
    monkeypatch.setattr(module, "learner_of", lambda *a, **k: original(*a, **k | {"lag": 0}))
    assert learnt(case, known).left(6, 12) > 3 * flexible.left(6, 12)


def test_constant_pitch_is_a_twin_in_the_same_wind(case, known, flexible):
    result = learnt(case, known, rotations=1, turbulence="C")
    first = result.record.passages.rms[0]
    # the first passage of the experiment is at rest: learner and twin are the same there
    np.testing.assert_array_equal(result.constant_rms[0], first)
    assert len(result.constant_rms) == len(result.record.passages)
    blades, before = 3, len(result.record.experiment)
    weights = case.weights.array[:4]
    rows = slice(before * blades, (before + 1) * blades)
    by_hand = (result.record.passages.rms[rows] @ weights).mean() / (
        result.constant_rms[rows] @ weights
    ).mean()
    assert result.left(1) == pytest.approx(by_hand, rel=1e-12)
    assert result.left(2) is None
    # turbulence is most of the loads, and of it what repeats with the rotor is a part
    assert result.judged_on == (10_000,)
    assert np.all(result.start.total > 2 * flexible.start.total)
    assert np.all(result.start.periodic < result.start.total)
    np.testing.assert_allclose(flexible.start.periodic, flexible.start.total, rtol=0.02)


def test_figures_of_held_loads_by_hand():
    random = np.random.default_rng(0)
    loads = random.normal(size=(5, 3, 4, 6))
    held = HeldLoads.of([0.0], [loads[:2], loads[2:]])
    rms = [[loads[r, :, i].ravel().std() for i in range(4)] for r in range(5)]
    np.testing.assert_allclose(rotation_rms(loads), rms)
    np.testing.assert_allclose(held.total, np.mean(rms, axis=0))
    np.testing.assert_allclose(held.periodic, loads.mean(axis=(0, 1)).std(axis=1))
    np.testing.assert_allclose(held.mean, loads.mean(axis=(0, 1, 3)))


def test_controller_keeps_the_mean_torque(windy):
    result = learnt(windy, None, rotor="controlled")  # with figures at the controller's torque
    assert result.reference.setpoint == result.setpoint
    assert result.left(8, 12) < 0.35
    mean = result.record.learning.mean_torque
    np.testing.assert_allclose(mean, result.setpoint, rtol=0.01)
    drift = np.rad2deg(result.record.learning.profile.mean(axis=1) - result.setup.start.pitch)
    assert np.abs(drift).max() < 1.0


def test_document_holds_plain_data(flexible, case):
    found = plain(flexible.document(case.settings()))
    assert [row["rotation"] for row in found["rotations"]] == list(range(1, 13))
    for row in found["rotations"]:
        ratio = row["rms_weighted"] / row["constant_rms_weighted"]
        assert row["left"] == pytest.approx(ratio, rel=1e-12)
    assert found["left"]["at_10"] == found["rotations"][9]["left"]
    assert found["left"]["at_20"] is None
    assert found["start"]["left_total"] == 1.0
    assert found["settings"]["turbine"]["rotor"] == "held"
    assert found["lag"]["samples"] == 2
    assert len(found["learned"]["pitch_deg"]) == 3 * M


def test_killed_run_goes_on_to_the_same_record_bit_for_bit(windy, windy_known, tmp_path):
    settings = LearningSettings(
        rotations=4, start_pitch=np.deg2rad(10.0), max_power_loss=LOSS, noise=0.02, seed=5
    )
    turbine = TurbineSettings(rotor="controlled", turbulence="B")
    path = tmp_path / "run.npz"

    def call(rotations: int = 4, **more: object) -> TurbineLearning:
        own = LearningSettings(**{**vars(settings), "rotations": rotations})
        return learn_on_turbine(windy, own, turbine, known=windy_known, judged=1, seeds=1, **more)

    whole = call()
    done = 0

    def stop(_: int, __: int, label: str) -> None:
        nonlocal done
        done += label == "learning"
        if done == 5:
            raise StopError

    with pytest.raises(StopError):
        call(checkpoint=path, progress=stop)
    again = call(checkpoint=path)
    one, other = whole.record.state(), again.record.state()
    assert one.keys() == other.keys()
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)
    # of another turbulence or structure: refused, and left alone
    before = path.read_bytes()
    with pytest.raises(InputError, match="other settings"):
        learn_on_turbine(
            windy,
            settings,
            TurbineSettings(rotor="controlled", turbulence="C"),
            known=windy_known,
            checkpoint=path,
        )
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("values", "learning", "turbine", "text"),
    [
        ({}, {"wind": ConstantWind(speed=9.0)}, {}, "wind: got ConstantWind on the dynamic"),
        ({}, {"difference": BladeDifference(chord=1.1)}, {}, "difference: got BladeDifference"),
        ({}, {"delay": M}, {}, "delay: got 12 samples beside a lag of 2"),
        ({}, {}, {"rotor": "controlled"}, "rotor: got 'controlled' at 9 m/s"),
        ({"limits.pitch_rate": 0.0}, {}, {}, "limits.pitch_rate_deg: got 0"),
        ({"aero.elements": 9}, {}, {}, "aero.elements: got 9"),
        ({"wind.speed": 30.0}, {}, {}, "cut-out at 25 m/s"),
    ],
)
def test_bad_input(case, known, values, learning, turbine, text):
    given = {"rotations": 1, "start_pitch": 0.03, "max_power_loss": LOSS} | learning
    with pytest.raises(InputError, match=text):
        learn_on_turbine(
            case.with_values(values),
            LearningSettings(**given),
            TurbineSettings(**turbine),
            known=known,
            judged=1,
        )


def test_turbine_without_structure_is_one_clear_error():
    with pytest.raises(InputError, match="'biegel2011': blade structure, hub, nacelle not known"):
        learn_on_turbine(load_case("biegel2011"))
