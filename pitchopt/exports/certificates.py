"""Files of certificates: bounds, what proves them, and the curves that they are about.

One NPZ file holds any number of certificates under their labels.  Curves that several share are
stored once.  Nothing in it is executed: arrays of numbers and text only.
"""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.aero.curves import BladeCurves
from pitchopt.aero.tables import CURVES, RATES
from pitchopt.design.proof import Certificate
from pitchopt.errors import InputError

__all__ = ["certificates_file", "read_certificates"]

_FORMAT = "pitchopt certificates 1"


def certificates_file(certificates: Mapping[str, Certificate]) -> bytes:
    """Content of one compressed NPZ file.

    Parameters
    ----------
    certificates : mapping of str to Certificate
        By label.
    """
    data: dict[str, Any] = {
        "format": np.array(_FORMAT),
        "labels": np.array(list(certificates), dtype=np.str_),
    }
    tables: list[BladeCurves] = []
    for number, certificate in enumerate(certificates.values()):
        curves = certificate.curves
        known = [i for i, table in enumerate(tables) if table is curves]
        if not known:
            known = [len(tables)]
            tables.append(curves)
        data[f"{number}/curves"] = known[0]
        data |= {f"{number}/{name}": value for name, value in certificate.arrays().items()}
    for number, table in enumerate(tables):
        prefix = f"curves{number}/"
        data[prefix + "blades"] = table.blades
        data[prefix + "mean_pitch"] = np.nan if table.mean_pitch is None else table.mean_pitch
        for name in ("azimuth", "beta", *CURVES, *RATES):
            data[prefix + name] = getattr(table, name)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **data)
    return buffer.getvalue()


def read_certificates(path: str | os.PathLike[str]) -> dict[str, Certificate]:
    """Certificates of a file by label.

    Raises
    ------
    InputError
        If the file is missing, holds no certificates, or numbers in it are none.
    """
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            data = {name: stored[name] for name in stored.files}
        if str(data["format"]) != _FORMAT:
            raise InputError(f"format {str(data['format'])!r}, expected {_FORMAT!r}")
        labels = [str(label) for label in np.atleast_1d(data["labels"])]
        if not labels or len(set(labels)) < len(labels):
            raise InputError(f"labels {labels}, expected at least one and no two alike")
        return {
            label: Certificate.from_arrays(
                _part(data, f"{number}/"), _curves(data, f"curves{int(data[f'{number}/curves'])}/")
            )
            for number, label in enumerate(labels)
        }
    except Exception as error:  # whatever a broken file does to its readers
        # numpy's advice, to unpickle what it does not know, is bad
        what = "not an .npz file" if "pickle" in str(error) else f"{type(error).__name__}: {error}"
        raise InputError(f"certificates: {path} holds none ({what})") from error


def _part(data: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    return {name[len(prefix) :]: value for name, value in data.items() if name.startswith(prefix)}


def _curves(data: Mapping[str, Any], prefix: str) -> BladeCurves:
    part = _part(data, prefix)
    mean = float(part.pop("mean_pitch"))
    blades = int(part.pop("blades"))
    return BladeCurves(blades=blades, mean_pitch=None if np.isnan(mean) else mean, **part)
