"""Turbulence boxes of HAWC2 (Mann) format.

One file a component, without a header: little-endian float32, x slowest, then y, z fastest,
``array[ix, iy, iz]``. The shape and the spacing must be known from elsewhere. Read as OpenFAST's
InflowWind reads them (WindType 5):

    ix = (U t - x) / dx mod Nx,   y = ((Ny - 1) / 2 - iy) dy,   z = centre + (iz - (Nz - 1) / 2) dz

so that slice 0 meets the tower axis at t = 0, time grows with ix, and iy runs from the left to
the right looking downwind. The fluctuations have no mean profile in them.

Reference: T. J. Larsen, A. M. Hansen, How 2 HAWC2, Risoe-R-1597, DTU; InflowWind manual, NREL.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from windfield._checks import as_count, as_number
from windfield.boxes import TurbulenceBox
from windfield.errors import WindFieldError

__all__ = ["read_hawc2"]

T = TypeVar("T", int, float)


def read_hawc2(
    u: str | os.PathLike[str],
    v: str | os.PathLike[str],
    w: str | os.PathLike[str],
    *,
    shape: tuple[int, int, int],
    spacing: tuple[float, float, float],
    mean_speed: float,
    centre_height: float,
    periodic: bool = True,
    offset: float = 0.0,
) -> TurbulenceBox:
    """Read a box from its three files.

    Parameters
    ----------
    u, v, w : path
        Files of the components along the mean wind, to the left and up.
    shape : (int, int, int)
        Nx, Ny, Nz, at least two each.
    spacing : (float, float, float)
        dx, dy, dz [m], positive.
    mean_speed : float
        U [m/s] that is to carry the box, positive.
    centre_height : float
        Height of the middle of the box [m].
    periodic : bool
        Boxes from a Fourier method are periodic along x.
    offset : float
        Slice that stands at the tower axis at t = 0.

    Raises
    ------
    WindFieldError
        If a file is missing, has another size than the shape tells, or holds NaN; or an
        argument is out of range.
    """
    nx, ny, nz = (as_count("shape", n, at_least=2) for n in _three("shape", shape))
    dx, dy, dz = (as_number("spacing", d, "m", above=0.0) for d in _three("spacing", spacing))
    velocity = np.empty((nx, ny, nz, 3), dtype=np.float32)
    for component, path in enumerate((u, v, w)):
        # from right to left as stored, from left to right here
        velocity[..., component] = _read(Path(path), (nx, ny, nz))[:, ::-1]
    middle = as_number("centre_height", centre_height, "m", above=0.0)
    return TurbulenceBox(
        velocity=velocity,
        y=(np.arange(ny, dtype=np.float64) - 0.5 * (ny - 1)) * dy,
        z=middle + (np.arange(nz, dtype=np.float64) - 0.5 * (nz - 1)) * dz,
        spacing=dx,
        mean_speed=mean_speed,
        periodic=periodic,
        offset=offset,
        label=f"HAWC2, {Path(u).name}",
    )


def _three(name: str, values: Sequence[T]) -> Sequence[T]:
    if len(values) != 3:
        raise WindFieldError(f"{name}: got {values!r}; must have three entries")
    return values


def _read(path: Path, shape: tuple[int, int, int]) -> NDArray[np.float32]:
    expected = 4 * shape[0] * shape[1] * shape[2]
    try:
        size = path.stat().st_size
        if size != expected:
            raise WindFieldError(
                f"{path}: got {size} bytes; must be {expected}, 4 for each of "
                f"{shape[0]} x {shape[1]} x {shape[2]} points"
            )
        values = np.fromfile(path, dtype="<f4")
    except OSError as error:
        raise WindFieldError(f"{path}: cannot be read ({error.strerror})") from error
    if not np.isfinite(values).all():
        raise WindFieldError(f"{path}: got NaN or infinite values; must be little-endian float32")
    return values.reshape(shape)
