"""Catalogue of reference turbines and the door to files: `load_turbine`, `names`, `summary`.

Every key stands for one JSON file of this package (format in `pitchopt.turbines.records`) which
names its sources.
"""

from __future__ import annotations

import difflib
from functools import lru_cache
from pathlib import Path

import numpy as np

from pitchopt.aero.blade import Blade
from pitchopt.errors import InputError
from pitchopt.turbines.files import load_json
from pitchopt.turbines.model import Turbine
from pitchopt.turbines.records import turbine_from_record
from pitchopt.turbines.windio import read_windio

__all__ = ["biegel_blade", "load_turbine", "names", "summary"]

_FOLDER = Path(__file__).parent / "data"
_KEYS = ("biegel2011", "nrel-5mw", "iea-3.4-130", "iea-10-198", "iea-15-240", "iea-22-280")
_RPM = np.pi / 30.0


def names() -> tuple[str, ...]:
    """Keys of the catalogue."""
    return _KEYS


@lru_cache(maxsize=len(_KEYS))
def _catalogue(key: str) -> Turbine:
    file = _FOLDER / f"{key}.json"
    return turbine_from_record(load_json(file), file.name)


def load_turbine(key_or_path: str | Path) -> Turbine:
    """Turbine of a catalogue key, a windIO v2 file (.yaml, .yml) or a record (.json).

    Parameters
    ----------
    key_or_path : str or path
        One of `names`, or a file.

    Raises
    ------
    InputError
        On an unknown key, naming all keys and the nearest, or on anything wrong in a file.
    """
    text = str(key_or_path)
    if text in _KEYS:
        return _catalogue(text)
    path = Path(key_or_path)
    suffix = path.suffix.lower()
    if suffix == ".json":
        return turbine_from_record(load_json(path), text)
    if suffix in {".yaml", ".yml"}:
        return read_windio(path)
    near = difflib.get_close_matches(text.lower(), _KEYS, n=1, cutoff=0.4)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise InputError(
        f"turbine: got {text[:80]!r}, expected one of {', '.join(_KEYS)}, "
        f"a windIO file (.yaml) or a record (.json){hint}"
    )


def biegel_blade(elements: int = 2, *, chord: float | None = None) -> Blade:
    """Blade of ``biegel2011`` cut into any number of equal elements.

    The twist is that of the design point at each element's centre (not interpolated),

        twist = atan(v / (omega r)) - atan(v / (omega R)).

    Parameters
    ----------
    elements : int
        Number of elements; the paper has 2.
    chord : float, optional
        Other chord [m] than the catalogue's.
    """
    if isinstance(elements, bool) or int(elements) != elements or elements < 1:
        raise InputError(f"elements: got {elements!r}, expected a whole number of at least 1")
    file = _FOLDER / "biegel2011.json"
    record = load_json(file)
    record["blade"]["elements"] = int(elements)
    if chord is not None:
        record["blade"]["chord"] = chord
    return turbine_from_record(record, file.name).rotor.blade


def summary(turbine: Turbine) -> dict[str, str | float | None]:
    """Headline figures in SI units (speeds in rpm where the key says so); None if not known."""
    structure = turbine.blade_structure
    return {
        "name": turbine.name,
        "rotor_diameter": 2.0 * turbine.rotor.radius,
        "hub_height": turbine.rotor.hub_height,
        "blades": float(turbine.rotor.blades),
        "rated_power": turbine.rated_power,
        "rated_rotor_speed_rpm": turbine.rated_rotor_speed / _RPM,
        "rated_wind_speed": turbine.rated_wind_speed,
        "blade_mass": None if structure is None else structure.mass,
        "tower_mass": turbine.tower.mass,
        "iec_class": turbine.iec_class,
        "source": turbine.source,
    }
