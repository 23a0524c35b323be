"""Sets of simulations: counted directly, kept, damaged, with any number of workers."""

from __future__ import annotations

import dataclasses
import errno
import math
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from pitchopt.errors import ComputationError, InputError
from pitchopt.fatigue import miner_damage, rainflow
from pitchopt.sim import DynamicTurbine, simulate
from pitchopt.studies.simulation import wind_cases
from pitchopt.studies.tower import (
    MOMENT_BINS,
    LoadSet,
    LoadSets,
    LoadSettings,
    Weld,
    scaled_start,
    station_joints,
)
from pitchopt.studies.tower import load_sets as module

SHORT = LoadSettings(
    wind_speeds=(8.0, 14.0), seeds=(1,), duration=20.0, skip=5.0, stations=5, axes=4, box_points=5
)
YEAR = 365.25 * 86400.0


@pytest.fixture(scope="module")
def make(turbine):
    """Makes sets that share the operation of the turbine."""
    operation = LoadSets(turbine, SHORT).operation

    def made(settings=SHORT, **options):
        sets = LoadSets(turbine, settings, **{"workers": 1, **options})
        if settings.stations == SHORT.stations:
            vars(sets)["operation"] = operation
        return sets

    return made


@pytest.fixture(scope="module")
def design(turbine):
    return scaled_start(turbine, 110.0)


@pytest.fixture(scope="module")
def memory(make, design):
    """Sets in memory and one that was run."""
    sets = make()
    return sets, sets.run(design, 0.1)


def equal(a: LoadSet, b: LoadSet, *, clock: bool = True) -> bool:
    """Bit for bit."""
    arrays = ("wind_speeds", "power", "power_deviation")
    return (
        np.array_equal(a.loads.cycles, b.loads.cycles)
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
        and (a.largest_speed, a.simulations, a.key) == (b.largest_speed, b.simulations, b.key)
        and (a.seconds == b.seconds or not clock)
    )


def rayleigh(low, high, mean):
    """Share of time between two speeds."""
    below, above = (math.exp(-math.pi / 4.0 * (v / mean) ** 2) for v in (low, high))
    return below - above


@pytest.fixture(scope="module")
def direct(memory, design):
    """The runs of the set, each by itself, with their share of time."""
    sets, _ = memory
    dynamic = DynamicTurbine(turbine=design.turbine, tower_sections=4)
    operation = sets.operation.on(dynamic)
    runs = []
    for case in wind_cases(dynamic, SHORT.simulated):
        run = simulate(
            dynamic, case.make(), operation.linear_quadratic(tower_velocity=0.1), 20.0,
            start=operation.start(case.wind_speed), interval=0.05,
        )  # fmt: skip
        runs.append((case.wind_speed, run))
    return runs


NAMES = [("TwrBsMyt", "TwrBsMxt"), ("TwHt1MLyt", "TwHt1MLxt"), ("TwHt2MLyt", "TwHt2MLxt"),
         ("TwHt3MLyt", "TwHt3MLxt"), ("YawBrMyp", "YawBrMxp")]  # fmt: skip
EDGES = {8.0: (5.0, 11.0), 14.0: (11.0, 17.0)}


def test_cycles_are_those_counted_directly(memory, direct):
    """Ranges to half a bin, numbers exactly: share of time, lifetime over time counted."""
    _, found = memory
    edges = np.append(MOMENT_BINS, MOMENT_BINS[-1] * math.exp(0.01)) * math.exp(-0.005)
    expected = np.zeros_like(found.loads.cycles)
    for speed, run in direct:
        rows = run.after(5.0)
        assert rows.shape[0] == 301  # both ends
        factor = rayleigh(*EDGES[speed], 7.5) * 20.0 * YEAR / (301 * 0.05)
        for s, (fore, side) in enumerate(NAMES):
            y, x = (rows[:, run.place(name)] for name in (fore, side))
            for a in range(4):
                series = math.cos(a * math.pi / 4.0) * y + math.sin(a * math.pi / 4.0) * x
                cycles = rainflow(series)
                expected[s, a] += (
                    factor
                    * np.histogram(
                        np.maximum(cycles.ranges, MOMENT_BINS[0]), edges, weights=cycles.counts
                    )[0]
                )
    np.testing.assert_allclose(found.loads.cycles, expected, rtol=1e-10, atol=1e-6)
    assert found.loads.cycles.sum() > 1e6


def test_damage_is_that_of_miner(memory, direct, design):
    """At each station on its own section, to what half a bin does to single cycles."""
    _, found = memory
    joints = station_joints(5, 10)
    middle, wall = design.joint_sections(joints)
    damage = found.loads.damage(joints, middle, wall).value
    weld = Weld()
    for p, (station, d, t) in enumerate(zip(joints.station, middle, wall, strict=True)):
        modulus = math.pi / 4.0 * d * t * (d**2 + t**2) / (d + t)
        factor = 1.1 * 1.15 * max(t / 0.025, 1.0) ** 0.2 / modulus
        over_axes = np.zeros(4)
        for speed, run in direct:
            rows = run.after(5.0)
            share = rayleigh(*EDGES[speed], 7.5) * 20.0 * YEAR / (301 * 0.05)
            y, x = (rows[:, run.place(name)] for name in NAMES[station])
            for a in range(4):
                angle = a * math.pi / 4.0
                cycles = rainflow(math.cos(angle) * y + math.sin(angle) * x)
                over_axes[a] += share * miner_damage(cycles, weld.curve, scale=factor)
        assert damage[p] == pytest.approx(over_axes.max(), rel=0.025)


def test_power_and_speed_are_those_of_the_runs(memory, direct):
    _, found = memory
    np.testing.assert_array_equal(found.wind_speeds, SHORT.wind_speeds)
    for k, (_, run) in enumerate(direct):
        power = run.after(5.0)[:, run.place("GenPwr")]
        assert found.power[k] == pytest.approx(power.mean(), rel=1e-12)
        assert found.power_deviation[k] == pytest.approx(power.std(), rel=1e-9)
    rotor = max(float(run.after(5.0)[:, run.place("RotSpeed")].max()) for _, run in direct)
    assert found.largest_speed == pytest.approx(rotor, rel=1e-9)  # the shaft is stiff
    assert found.simulations == 2
    assert found.seconds > 0.0


def test_moments_are_those_of_the_stations(direct):
    """Moments grow downward; in the mean by the thrust times the distance of the stations."""
    for _, run in direct:
        rows = run.after(5.0)
        mean = [float(rows[:, run.place(fore)].mean()) for fore, _ in NAMES]
        assert np.all(np.diff(mean) < 0.0)
        steps = np.diff(mean)
        np.testing.assert_allclose(steps, steps.mean(), rtol=0.1)  # the head's weight bends too


def test_damage_of_two_seeds_is_their_mean(make, design, memory):
    both = make(dataclasses.replace(SHORT, seeds=(1, 2))).run(design, 0.1)
    second = make(dataclasses.replace(SHORT, seeds=(2,))).run(design, 0.1)
    mean = 0.5 * (memory[1].loads.cycles + second.loads.cycles)
    np.testing.assert_allclose(both.loads.cycles, mean, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(both.power, 0.5 * (memory[1].power + second.power), rtol=1e-12)
    assert both.simulations == 4


def test_cycles_scale_with_the_lifetime_and_follow_the_wind_of_the_site(make, design, memory):
    """The same runs, other weights."""
    other = dataclasses.replace(SHORT, lifetime=35.0, mean_wind_speed=9.0)
    found = make(other).run(design, 0.1)
    np.testing.assert_array_equal(found.power, memory[1].power)
    ratios = {
        speed: 35.0 / 20.0 * rayleigh(*EDGES[speed], 9.0) / rayleigh(*EDGES[speed], 7.5)
        for speed in EDGES
    }
    total, before = found.loads.cycles, memory[1].loads.cycles
    there = before > 0.0
    ratio = total[there] / before[there]
    low, high = sorted(ratios.values())
    assert ratio.min() == pytest.approx(low, rel=1e-9)  # bins of one speed alone
    assert ratio.max() == pytest.approx(high, rel=1e-9)


def test_higher_hub_has_more_wind(make, design):
    """Weights are those of the site's mean wind at the design's own hub."""
    higher = dataclasses.replace(design, hub_height=125.0)
    found, windy = (
        make(dataclasses.replace(SHORT, mean_wind_speed=mean)).run(higher, 0.1).loads.cycles
        for mean in (7.5, 9.0)
    )
    lift = (125.0 / 110.0) ** 0.2
    ratios = [rayleigh(*EDGES[u], 9.0 * lift) / rayleigh(*EDGES[u], 7.5 * lift) for u in EDGES]
    ratio = windy[found > 0.0] / found[found > 0.0]
    assert ratio.min() == pytest.approx(min(ratios), rel=1e-9)
    assert ratio.max() == pytest.approx(max(ratios), rel=1e-9)


# --- keys -------------------------------------------------------------------------------------


CHANGED = {
    "wind_speeds": (8.0, 15.0), "seeds": (2,), "duration": 21.0, "skip": 6.0, "interval": 0.1,
    "turbulence": "B", "mean_wind_speed": 8.0, "shear": 0.1, "lifetime": 25.0, "stations": 6,
    "axes": 3, "box_points": 6,
}  # fmt: skip


def test_key_answers_to_everything(make, design, turbine):
    assert set(CHANGED) == {field.name for field in dataclasses.fields(LoadSettings)}
    sets = make()
    keys = {sets.key(design, 0.1)}
    for name, value in CHANGED.items():
        other = LoadSets(turbine, dataclasses.replace(SHORT, **{name: value}))
        keys.add(other.key(design, 0.1))
    thicker = np.array(design.thickness)
    thicker[3] *= 1.0 + 1e-12
    wider = np.array(design.diameter)
    wider[-1] += 1e-12
    for changed in (
        dataclasses.replace(design, hub_height=110.0 + 1e-9),
        dataclasses.replace(design, thickness=thicker),
        dataclasses.replace(design, diameter=wider),
    ):
        keys.add(sets.key(changed, 0.1))
    keys |= {sets.key(design, 0.0), sets.key(design, 0.1 + 1e-12)}
    renamed = dataclasses.replace(turbine, name="another")
    keys.add(LoadSets(renamed, SHORT).key(design, 0.1))
    assert len(keys) == 1 + len(CHANGED) + 3 + 2 + 1


def test_key_answers_to_all_data_of_the_turbine(design, turbine):
    """A file that was changed keeps its name, and a set must not outlive it."""
    rotor, structure = turbine.rotor, turbine.blade_structure
    nacelle = dataclasses.replace(turbine.nacelle, mass=turbine.nacelle.mass + 1.0)
    tower = dataclasses.replace(turbine.tower, youngs_modulus=2.05e11)
    heavier = dataclasses.replace(structure, mass_per_length=1.001 * structure.mass_per_length)
    chord = dataclasses.replace(rotor.blade, chord=1.001 * rotor.blade.chord)
    changed = [
        turbine,
        dataclasses.replace(turbine, nacelle=nacelle),
        dataclasses.replace(turbine, tower=tower),
        dataclasses.replace(turbine, blade_structure=heavier),
        dataclasses.replace(turbine, air_density=1.2),
        dataclasses.replace(turbine, rotor=dataclasses.replace(rotor, blade=chord)),
    ]
    keys = {LoadSets(machine, SHORT).key(design, 0.1) for machine in changed}
    assert len(keys) == len(changed)
    copied = dataclasses.replace(
        turbine,
        blade_structure=dataclasses.replace(structure),
        tower=dataclasses.replace(turbine.tower),
    )
    assert LoadSets(copied, SHORT).key(design, 0.1) in keys


def test_key_answers_to_nothing_else(make, design, tmp_path):
    key = make().key(design, 0.1)
    again = dataclasses.replace(design, hub_height=110, thickness=list(design.thickness))
    assert make(folder=tmp_path, workers=2, on_run=print).key(again, 0.1) == key
    # welds act on the cycles, which a set holds without them
    assert make(weld=Weld(safety_factor=1.5)).key(design, 0.1) == key
    assert make(dataclasses.replace(SHORT)).key(design, np.float64(0.1)) == key


def test_format_is_part_of_the_key(make, design, monkeypatch):
    key = make().key(design, 0.1)
    monkeypatch.setattr(module, "FORMAT", module.FORMAT + 1)
    assert make().key(design, 0.1) != key


# --- in memory and in the folder ----------------------------------------------------------------


def nothing_runs(*_, **__):
    pytest.fail("simulated")


def test_set_in_memory_is_not_simulated_again(memory, design, monkeypatch):
    sets, found = memory
    monkeypatch.setattr(module, "simulate_many", nothing_runs)
    assert sets.simulated == 1
    assert sets.has(design, 0.1)
    assert not sets.has(design, 0.2)
    assert sets.run(design, 0.1) is found


@pytest.fixture(scope="module")
def stored(make, design, tmp_path_factory):
    """Folder with a set."""
    folder = tmp_path_factory.mktemp("sets") / "deep" / "down"
    sets = make(folder=folder)
    return folder, sets.run(design, 0.1)


@pytest.fixture
def folder(stored, tmp_path):
    """A copy of it."""
    (path,) = stored[0].iterdir()
    (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def test_set_from_the_folder_is_the_one_simulated(make, design, stored, memory, monkeypatch):
    folder, first = stored
    assert equal(first, memory[1], clock=False)
    assert [path.suffixes for path in folder.iterdir()] == [[".set", ".npz"]]
    monkeypatch.setattr(module, "simulate_many", nothing_runs)
    sets = make(folder=str(folder))
    assert sets.has(design, 0.1)
    found = sets.run(design, 0.1)
    assert equal(found, first)
    assert found.loads.weld == first.loads.weld
    assert sets.simulated == 0
    strict = make(folder=folder, weld=Weld(safety_factor=2.0)).run(design, 0.1)
    assert strict.loads.weld.safety_factor == 2.0
    assert equal(strict, first)


def _truncated(data):
    return data[: len(data) // 2]


def _in_the_middle(data):
    """Bytes of the compressed cycles are changed."""
    middle = len(data) // 3
    return data[:middle] + bytes(b ^ 0xFF for b in data[middle : middle + 40]) + data[middle + 40 :]


def _header(data):
    place = data.index(b"PK\x01\x02") + 10
    return data[:place] + bytes([99, 0]) + data[place + 2 :]  # a compression that nobody knows


def _npy(_):
    import io

    stream = io.BytesIO()
    np.save(stream, np.zeros(3))
    return stream.getvalue()


def _pickle(_):
    return b"\x80\x04\x95\x0b\x00\x00\x00\x00\x00\x00\x00\x8c\x07nothing\x94."


@pytest.mark.parametrize(
    "damage",
    [_truncated, _in_the_middle, _header, _npy, _pickle, lambda _: b"", lambda _: b"PK\x03\x04"],
)
def test_damaged_set_is_made_again_and_replaced(make, design, folder, stored, damage):
    (path,) = folder.iterdir()
    path.write_bytes(damage(path.read_bytes()))
    sets = make(folder=folder)
    assert not sets.has(design, 0.1)
    found = sets.run(design, 0.1)
    assert sets.simulated == 1
    assert equal(found, stored[1], clock=False)
    again = make(folder=folder)
    assert equal(again.run(design, 0.1), found)
    assert again.simulated == 0
    assert list(folder.iterdir()) == [path]


def test_no_changed_byte_is_taken_for_a_result(make, design, folder, stored):
    """Every file that still reads is the one that was written."""
    (path,) = folder.iterdir()
    data = path.read_bytes()
    rng = np.random.default_rng(3)
    places = {
        *rng.integers(0, len(data), 150).tolist(),
        *range(60),
        *range(len(data) - 60, len(data)),
    }
    refused = 0
    for place in sorted(places):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x55]) + data[place + 1 :])
        sets = make(folder=folder)
        if sets.has(design, 0.1):
            assert equal(sets.run(design, 0.1), stored[1])
        else:
            refused += 1
    assert refused > 100


@pytest.mark.parametrize(
    "change", [{"key": "0" * 64}, {"cycles": np.zeros((5, 4, 3))}, {"power": None}]
)
def test_foreign_set_under_its_name_is_replaced(make, design, folder, stored, change):
    (path,) = folder.iterdir()
    with np.load(path) as file:
        parts = {**file, **change}
    np.savez(path, **{name: part for name, part in parts.items() if part is not None})
    sets = make(folder=folder)
    assert equal(sets.run(design, 0.1), stored[1], clock=False)
    assert sets.simulated == 1


def test_stopped_while_writing_leaves_no_file(make, design, folder, memory, monkeypatch):
    def half(file, **_):
        file.write(b"PK half")
        raise KeyboardInterrupt

    (path,) = folder.iterdir()
    path.unlink()
    monkeypatch.setattr(np, "savez_compressed", half)
    with pytest.raises(KeyboardInterrupt):
        make(folder=folder)._store(memory[1])
    assert list(folder.iterdir()) == []


def test_full_disk_is_one_clear_error(make, design, folder, memory, monkeypatch):
    def full(file, **_):
        file.write(b"PK half")
        raise OSError(errno.ENOSPC, "No space left on device")

    (path,) = folder.iterdir()
    path.unlink()
    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(ComputationError, match=r"could not be written \(No space left on device\)"):
        make(folder=folder)._store(memory[1])
    assert list(folder.iterdir()) == []


_KILLED = """
import os, signal, sys
import numpy as np
from pitchopt.studies.tower import MOMENT_BINS, FatigueLoads, LoadSet, LoadSets
from pitchopt.turbines import load_turbine

def half(file, **_):
    file.write(b"PK half of it")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)

np.savez_compressed = half
one = np.ones(1)
LoadSets(load_turbine("iea-3.4-130"), folder=sys.argv[1])._store(
    LoadSet(
        loads=FatigueLoads(cycles=np.ones((2, 1, MOMENT_BINS.size))), wind_speeds=one, power=one,
        power_deviation=one, largest_speed=1.0, simulations=1, seconds=1.0, key=sys.argv[2],
    )
)
"""


def test_killed_while_writing_leaves_the_former_set_or_none(
    make, design, folder, stored, project_root
):
    """A part file at most, which nobody reads and nothing trips over."""
    (path,) = folder.iterdir()
    data = path.read_bytes()
    done = subprocess.run(
        [sys.executable, "-c", _KILLED, str(folder), stored[1].key],
        env={**os.environ, "PYTHONPATH": str(project_root)}, check=False,
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL
    left = sorted(p.name for p in folder.iterdir())
    assert len(left) == 2
    assert left[0] == path.name
    assert left[1].endswith(".part")
    assert path.read_bytes() == data
    path.unlink()
    sets = make(folder=folder)
    assert not sets.has(design, 0.1)
    assert equal(sets.run(design, 0.1), stored[1], clock=False)


# --- runs ---------------------------------------------------------------------------------------


def test_workers_change_nothing(make, design, memory):
    told = []
    sets = make(workers=2, on_run=lambda *counts: told.append(counts))
    assert equal(sets.run(design, 0.1), memory[1], clock=False)
    assert told == [(1, 2), (2, 2)]


@pytest.mark.parametrize("height", [99.0, 132.0])
def test_boxes_are_moved_up_with_the_hub(make, design, height):
    """The same turbulence about each hub, and the one that a box made there would hold."""
    sets = make()
    fields = {}
    for h in (110.0, height):
        moved = dataclasses.replace(design, hub_height=h)
        dynamic = DynamicTurbine(turbine=moved.turbine, tower_sections=4)
        for case in wind_cases(dynamic, SHORT.simulated):
            # without the tower's shadow, which is another for each tower
            plain = dataclasses.replace(case, mean=dataclasses.replace(case.mean, tower=None))
            fields[h, case.wind_speed] = sets._wind(plain), case
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-5.0, 5.0, 40), rng.uniform(-60.0, 60.0, 40)
    z, t = rng.uniform(50.0, 170.0, 40), rng.uniform(0.0, 20.0, 40)
    for speed in SHORT.wind_speeds:
        (low, _), (high, case) = fields[110.0, speed], fields[height, speed]
        lift = height - 110.0
        gust = low.velocity(x, y, z, t) - low.mean.velocity(x, y, z, t)
        moved = high.velocity(x, y, z + lift, t) - high.mean.velocity(x, y, z + lift, t)
        np.testing.assert_allclose(moved, gust, atol=1e-9)
        assert np.abs(gust).max() > 1.0
        # the hub meets the same mean speed
        at_hub = high.mean.velocity(0.0, 0.0, height)
        assert float(np.hypot(*at_hub[..., :2].ravel())) == pytest.approx(speed)
        own = dataclasses.replace(case.make(), mean=high.mean)
        np.testing.assert_allclose(
            own.velocity(x, y, z + lift, t), high.velocity(x, y, z + lift, t), atol=1e-9
        )


def test_boxes_are_made_once(make, design, monkeypatch):
    sets = make()
    made = []
    original = LoadSets._box
    monkeypatch.setattr(
        LoadSets, "_box", lambda self, *key: made.append(key) or original(self, *key)
    )
    sets.run(design, 0.0)
    sets.run(dataclasses.replace(design, hub_height=120.0), 0.3)
    assert sorted(made) == [(8.0, 1), (14.0, 1)]


def test_diverged_run_says_which(make, design, tmp_path, monkeypatch):
    def many(dynamic, winds, *args, on_result, **_):
        assert len(winds) == 2
        good = simulate_one()
        on_result(good)
        on_result(SimpleNamespace(status="diverged", message="diverged at 3.2 s"))

    def simulate_one():
        channels = [name for pair in NAMES for name in pair] + ["GenPwr", "GenSpeed"]
        rows = np.zeros((30, len(channels)))
        return SimpleNamespace(
            status="finished", interval=0.05, place=channels.index, after=lambda _: rows
        )

    monkeypatch.setattr(module, "simulate_many", many)
    sets = make(folder=tmp_path)
    with pytest.raises(
        ComputationError,
        match=r"^the run at 14 m/s, seed 1, with c = 0\.2 on a tower of \d+ t diverged at 3\.2 s$",
    ):
        sets.run(design, 0.2)
    assert list(tmp_path.iterdir()) == []
    assert sets.simulated == 0
    assert not sets.has(design, 0.2)


def test_hub_that_is_too_low(make, design, monkeypatch):
    monkeypatch.setattr(module, "simulate_many", nothing_runs)
    with pytest.raises(InputError, match=r"hub_height: got 59\.9, expected .*60"):
        make().run(dataclasses.replace(design, hub_height=59.9), 0.1)


@pytest.mark.parametrize("weight", [-0.1, math.nan, math.inf])
def test_bad_weight(make, design, weight, monkeypatch):
    monkeypatch.setattr(module, "simulate_many", nothing_runs)
    with pytest.raises(InputError, match="tower_velocity"):
        make().run(design, weight)


def test_folder_that_cannot_be_made(make, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    for folder in (file, file / "below"):
        with pytest.raises(InputError, match="cannot be made or is not a folder"):
            make(folder=folder)


def test_bad_workers(make):
    with pytest.raises(InputError, match="workers"):
        make(workers=0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"wind_speeds": (9.0,)}, "at least 2 increasing speeds"),
        ({"wind_speeds": (9.0, 7.0)}, "at least 2 increasing speeds"),
        ({"seeds": ()}, "seeds"),
        ({"duration": 0.0}, "duration"),
        ({"skip": 11.0}, "skip"),
        ({"interval": 0.0}, "interval"),
        ({"turbulence": "Q"}, "turbulence"),
        ({"mean_wind_speed": 0.0}, "mean_wind_speed"),
        ({"shear": -0.1}, "shear"),
        ({"lifetime": math.nan}, "lifetime"),
        ({"stations": 1}, "stations"),
        ({"axes": 0}, "axes"),
        ({"box_points": 1}, "box_points"),
    ],
)
def test_bad_settings(change, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(SHORT, **change)
