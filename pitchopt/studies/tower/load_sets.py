"""Full sets of simulations: a tower and its controller over all wind speeds and seeds.

One set runs the dynamic turbine with the linear quadratic regulator of weight c in turbulence of
every mean speed and seed, counts the cycles of the tower's bending moments at all stations about
several axes, and adds them up over the lifetime with the weights of the wind speeds,

    n_i = sum_V p(V) / seeds  sum_seeds  n_i(V, seed)  lifetime / time counted.

Every set meets the same turbulence (common random numbers): boxes are made once and carried by
each design's own mean wind, so that two sets differ by tower and controller alone.  Boxes of the
Kaimal model do not depend on the hub height above 60 m.

Sets are kept in a folder, one file each, named by a digest of all that they depend on; a study that
was stopped goes on with them.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import threading
import time as clock
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.fatigue import bin_edges, range_spectra, weibull_weights
from pitchopt.sim import DynamicTurbine, Operation, Simulation, simulate_many
from pitchopt.studies.simulation import WindCase, wind_cases
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.energy import mean_wind_at
from pitchopt.studies.tower.fatigue_loads import BIN_WIDTH, MOMENT_BINS, FatigueLoads, Weld
from pitchopt.studies.tower.load_settings import LoadSettings
from pitchopt.turbines import Turbine
from windfield import BoxCache, TurbulenceBox, TurbulentField

__all__ = ["LEAST_HUB", "LoadSet", "LoadSets"]

FORMAT = 2  # to be raised whenever the same settings give other results
_YEAR = 365.25 * 86400.0
LEAST_HUB = 60.0  # below, the turbulence's length scale follows the hub height [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadSet:
    """Result of a set.

    Attributes
    ----------
    loads : FatigueLoads
        Over the lifetime.
    wind_speeds, power, power_deviation : ndarray (V,)
        Mean speed at the hub [m/s], and mean and standard deviation of the electrical power over
        all seeds [W].
    largest_speed : float
        Of the rotor in any run [rad/s].
    simulations : int
    seconds : float
        Wall time; that of the first time for a set from the folder.
    key : str
        Digest of all that the set depends on.
    """

    loads: FatigueLoads
    wind_speeds: FloatArray
    power: FloatArray
    power_deviation: FloatArray
    largest_speed: float
    simulations: int
    seconds: float
    key: str


class LoadSets:
    """Sets of one turbine, made when they are asked for and kept.

    Parameters
    ----------
    reference : Turbine
    settings : LoadSettings
    weld : Weld
        For the loads of the sets.
    folder : path, optional
        Where sets are kept; in memory only without.
    workers : int, optional
        Threads; as many as there are cores without.
    cache : BoxCache, optional
        Where turbulence boxes are kept on disk.
    on_run : callable, optional
        Called after each simulation with how many of the set are done and how many there are.

    Attributes
    ----------
    simulated : int
        Sets that were simulated, not found in the folder.

    Raises
    ------
    InputError
        If the turbine lacks data, or the folder cannot be made.
    """

    def __init__(
        self,
        reference: Turbine,
        settings: LoadSettings | None = None,
        *,
        weld: Weld | None = None,
        folder: str | os.PathLike[str] | None = None,
        workers: int | None = None,
        cache: BoxCache | None = None,
        on_run: Callable[[int, int], None] | None = None,
    ) -> None:
        self.reference = reference
        self.settings = LoadSettings() if settings is None else settings
        self.weld = Weld() if weld is None else weld
        self.workers = (
            os.cpu_count() or 1 if workers is None else whole_number("workers", workers, at_least=1)
        )
        self.cache = cache
        self.on_run = on_run
        self.simulated = 0
        self.folder = None if folder is None else Path(folder)
        if self.folder is not None:
            try:
                self.folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise InputError(
                    f"{self.folder}: cannot be made or is not a folder ({error.strerror}); choose "
                    "another folder for the sets"
                ) from error
        self._kept: dict[str, LoadSet] = {}
        self._boxes: dict[tuple[float, int], TurbulenceBox] = {}
        self._locks: dict[tuple[float, int], threading.Lock] = {}
        self._lock = threading.Lock()

    @cached_property
    def operation(self) -> Operation:
        """Steady operation on the reference's own tower."""
        operation = Operation(self._moving(self.reference))
        operation.linear_quadratic()
        return operation

    @cached_property
    def _machine(self) -> str:
        """Digest of all data of the reference turbine."""
        digest = hashlib.sha256()
        _feed(digest.update, self.reference)
        return digest.hexdigest()

    def _moving(self, turbine: Turbine) -> DynamicTurbine:
        return DynamicTurbine(turbine=turbine, tower_sections=self.settings.stations - 1)

    def key(self, design: TowerDesign, tower_velocity: float) -> str:
        """Digest of all that a set depends on."""
        document = {
            "format": FORMAT,
            "turbine": self._machine,
            "settings": dataclasses.asdict(self.settings),
            "height": float(design.hub_height),
            "diameter": design.diameter.tolist(),
            "thickness": design.thickness.tolist(),
            "weight": float(tower_velocity),
        }
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()

    def has(self, design: TowerDesign, tower_velocity: float) -> bool:
        """Whether a set need not be simulated."""
        key = self.key(design, tower_velocity)
        return key in self._kept or self._stored(key) is not None

    def run(self, design: TowerDesign, tower_velocity: float) -> LoadSet:
        """Set of a design with the weight c on the tower-top velocity [s^2/m^2].

        Raises
        ------
        InputError
            If the design's hub is too low, or the weight is negative.
        ComputationError
            If a run diverged, or the set could not be written.
        """
        finite_number("tower_velocity", tower_velocity, at_least=0.0)
        finite_number("hub_height", design.hub_height, at_least=LEAST_HUB)
        key = self.key(design, tower_velocity)
        if key not in self._kept:
            found = self._stored(key)
            if found is None:
                found = self._simulated(design, tower_velocity, key)
                self.simulated += 1
                self._store(found)
            self._kept[key] = found
        return self._kept[key]

    def _simulated(self, design: TowerDesign, tower_velocity: float, key: str) -> LoadSet:
        began = clock.perf_counter()
        settings, dynamic = self.settings, self._moving(design.turbine)
        operation = self.operation.on(dynamic)
        cases = wind_cases(dynamic, settings.simulated)
        counter = _Counter(settings, dynamic)
        site = mean_wind_at(
            design.hub_height,
            reference_height=self.reference.rotor.hub_height,
            reference_speed=settings.mean_wind_speed,
            exponent=settings.shear,
        )
        weights = weibull_weights(bin_edges(settings.wind_speeds), mean=float(site))
        share = dict(zip(settings.wind_speeds, weights, strict=True))
        done = 0

        def count(run: Simulation) -> None:
            nonlocal done
            case = cases[done]
            if run.status != "finished":
                raise ComputationError(
                    f"the run at {case.wind_speed:g} m/s, seed {case.seed}, with c = "
                    f"{tower_velocity:g} on a tower of {design.mass / 1e3:.0f} t {run.message}"
                )
            counter.add(run, case.wind_speed, share[case.wind_speed])
            done += 1
            if self.on_run is not None:
                self.on_run(done, len(cases))

        simulate_many(
            dynamic,
            [partial(self._wind, case) for case in cases],
            operation.linear_quadratic(tower_velocity=tower_velocity),
            settings.duration,
            start=[operation.start(case.wind_speed) for case in cases],
            interval=settings.interval,
            workers=self.workers,
            on_result=count,
        )
        return counter.result(
            weld=self.weld, seconds=clock.perf_counter() - began, key=key, simulations=len(cases)
        )

    def _wind(self, case: WindCase) -> TurbulentField:
        """Wind of a case, its box made by whoever asks first while others wait for it."""
        key = (case.wind_speed, case.seed or 0)
        with self._lock:
            lock = self._locks.setdefault(key, threading.Lock())
        with lock:
            if key not in self._boxes:
                self._boxes[key] = self._box(*key)
        box, lift = self._boxes[key], case.mean.hub_height - self.reference.rotor.hub_height
        return TurbulentField(mean=case.mean, box=dataclasses.replace(box, z=box.z + lift))

    def _box(self, speed: float, seed: int) -> TurbulenceBox:
        """Box about the reference turbine's own hub."""
        settings = dataclasses.replace(self.settings.simulated, wind_speeds=(speed,), seeds=(seed,))
        field = wind_cases(self.operation.dynamic, settings, self.cache)[0].make()
        assert isinstance(field, TurbulentField)  # the settings ask for turbulence
        assert isinstance(field.box, TurbulenceBox)
        return field.box

    def _path(self, key: str) -> Path | None:
        return None if self.folder is None else self.folder / f"{key[:32]}.set.npz"

    def _stored(self, key: str) -> LoadSet | None:
        """A set from the folder; None where there is none or it cannot be read."""
        path = self._path(key)
        if path is None or not path.is_file():
            return None
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                if str(file["key"]) != key:
                    return None
                return LoadSet(
                    loads=FatigueLoads(cycles=file["cycles"], weld=self.weld),
                    key=key,
                    simulations=int(file["simulations"]),
                    seconds=float(file["seconds"]),
                    largest_speed=float(file["largest_speed"]),
                    **{name: file[name] for name in _ARRAYS},
                )
        except _DAMAGED:
            return None  # made again and replaced

    def _store(self, found: LoadSet) -> None:
        path = self._path(found.key)
        if path is None:
            return
        part = path.with_name(f"{path.name}.{os.getpid()}.part")
        arrays: dict[str, Any] = {name: getattr(found, name) for name in _ARRAYS}
        try:
            with part.open("wb") as file:
                np.savez_compressed(
                    file,
                    cycles=found.loads.cycles,
                    key=np.array(found.key),
                    simulations=found.simulations,
                    seconds=found.seconds,
                    largest_speed=found.largest_speed,
                    **arrays,
                )
            part.replace(path)
        except OSError as error:
            raise ComputationError(
                f"{path}: the set could not be written ({error.strerror or error}); make room or "
                "choose another folder, those before it are kept"
            ) from error
        finally:
            part.unlink(missing_ok=True)


def _feed(update: Callable[[bytes], None], value: object) -> None:
    """Tell all fields of dataclasses, items and numbers, each with its kind."""
    update(f"{type(value).__name__}:".encode())
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            update(f"{field.name}=".encode())
            _feed(update, getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        update(f"{value.shape}{value.dtype.str}".encode())
        update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, Mapping):
        for key in sorted(value):
            update(f"{key}=".encode())
            _feed(update, value[key])
    elif isinstance(value, list | tuple):
        update(f"{len(value)}".encode())
        for item in value:
            _feed(update, item)
    else:
        update(f"{value!r};".encode())


_ARRAYS = ("wind_speeds", "power", "power_deviation")
_DAMAGED = (  # what numpy and zipfile raise on files that are cut, changed or of another kind
    OSError,
    KeyError,
    ValueError,
    TypeError,
    EOFError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)


class _Counter:
    """Cycles and power of a set's runs, added up as they come."""

    def __init__(self, settings: LoadSettings, dynamic: DynamicTurbine) -> None:
        self.settings = settings
        inner = range(1, settings.stations - 1)
        self.fore_aft = ["TwrBsMyt", *(f"TwHt{k}MLyt" for k in inner), "YawBrMyp"]
        self.side_side = ["TwrBsMxt", *(f"TwHt{k}MLxt" for k in inner), "YawBrMxp"]
        angle = np.pi * np.arange(settings.axes) / settings.axes
        self.cosines, self.sines = np.cos(angle), np.sin(angle)
        shape = (settings.stations, settings.axes, MOMENT_BINS.size)
        self.cycles = np.zeros(shape)
        self.power: dict[float, list[FloatArray]] = {u: [] for u in settings.wind_speeds}
        self.largest = 0.0
        self.gear = dynamic.turbine.drivetrain.gear_ratio

    def add(self, run: Simulation, speed: float, share: float) -> None:
        settings = self.settings
        rows = run.after(settings.skip)
        counted = rows.shape[0] * run.interval
        factor = share / len(settings.seeds) * settings.lifetime * _YEAR / counted
        fore, side = (
            rows[:, [run.place(name) for name in names]].T
            for names in (self.fore_aft, self.side_side)
        )
        moments = self.cosines[:, None] * fore[:, None] + self.sines[:, None] * side[:, None]
        found = range_spectra(
            moments.reshape(-1, rows.shape[0]),
            first=float(MOMENT_BINS[0]),
            width=BIN_WIDTH,
            bins=MOMENT_BINS.size,
        )
        self.cycles += factor * found.reshape(self.cycles.shape)
        self.power[speed].append(rows[:, run.place("GenPwr")].copy())
        self.largest = max(self.largest, float(rows[:, run.place("GenSpeed")].max()) / self.gear)

    def result(self, *, weld: Weld, seconds: float, key: str, simulations: int) -> LoadSet:
        power = [np.concatenate(self.power[u]) for u in self.settings.wind_speeds]
        return LoadSet(
            loads=FatigueLoads(cycles=self.cycles, weld=weld),
            wind_speeds=np.array(self.settings.wind_speeds),
            power=np.array([p.mean() for p in power]),
            power_deviation=np.array([p.std() for p in power]),
            largest_speed=self.largest,
            simulations=simulations,
            seconds=seconds,
            key=key,
        )
