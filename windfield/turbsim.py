"""Full-field binary files of TurbSim (.bts), which OpenFAST's InflowWind reads (WindType 3).

Little-endian; a header of 70 bytes,

    int16  7, or 8 when the wind is periodic in time
    int32  Nz, Ny, number of tower points, number of time steps
    float32  dz, dy [m], dt [s], mean speed U at the reference height [m/s], that height,
             height of the lowest row [m]
    float32  slope and offset of u, of v, of w
    int32  length of the description, which follows as text

and for each time step the grid (z slowest, then y from right to left looking downwind, the
component fastest), then the tower points, as int16 with velocity = (count - offset) / slope.

The velocities contain the mean wind. Reading subtracts U g(z), where the shear g is either given
or the file's own mean over time and y, relative to that at the reference height and linear in
between (`TableShear`). With the file's own, mean and box add up to the file's velocities between
the grid points too. What the mean at the reference height differs from U stays in the box.

InflowWind lets a periodic file start at the tower axis, any other one half a grid width
downwind of it, so that a yawed rotor finds wind at t = 0:

    i = (U t - x) / dx + offset,    offset = 0 or (Ny - 1) dy / 2 / dx,    dx = U dt.

Boxes are read with that offset; one with another cannot be written.

References: B. J. Jonkman, TurbSim User's Guide, NREL, appendix on the full-field binary format;
InflowWind manual and source, OpenFAST.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from windfield._checks import FloatArray, ValueSemantics
from windfield._files import write_whole
from windfield.boxes import TurbulenceBox
from windfield.errors import WindFieldError
from windfield.field import StaticField
from windfield.shear import TableShear, VerticalShear
from windfield.tower import TowerShadow
from windfield.turbulent import TurbulentField

__all__ = ["TurbSimWind", "read_bts", "write_bts"]

HEADER = struct.Struct("<h4i12fi")
STEADY_END, PERIODIC = 7, 8
LOWEST, COUNTS = -32767, 65533  # of int16, with one to spare for rounding at either end
NARROWEST = 0.01  # range of the counts over the largest velocity
LONGEST_TEXT = 200
CHUNK = 2**22  # numbers decoded at once
SLACK = 1e-6  # of a step: rounding of coordinates


@dataclass(frozen=True, kw_only=True, eq=False)
class TurbSimWind(ValueSemantics):
    """Content of a .bts file.

    Attributes
    ----------
    box : TurbulenceBox
        Velocities less the mean wind, with InflowWind's offset in time.
    vertical : VerticalShear
        Shear g of the mean wind that was subtracted.
    reference_height : float
        [m]; the mean speed there is `box.mean_speed`.
    description : str
        Text of the file.
    """

    box: TurbulenceBox
    vertical: VerticalShear
    reference_height: float
    description: str

    def field(self, tower: TowerShadow | None = None) -> TurbulentField:
        """Wind field of the file; its hub height is the reference height."""
        mean = StaticField(
            speed=self.box.mean_speed,
            hub_height=self.reference_height,
            vertical=self.vertical,
            tower=tower,
        )
        return TurbulentField(mean=mean, box=self.box)


def read_bts(path: str | os.PathLike[str], *, vertical: VerticalShear | None = None) -> TurbSimWind:
    """Read a file; points on the tower below the grid are left out.

    Parameters
    ----------
    path : path
    vertical : VerticalShear or None
        Shear of the mean wind to subtract; None: the file's own, see the module. For none at
        all, give ``PowerLaw(exponent=0.0)``.

    Raises
    ------
    WindFieldError
        If the file is missing, not of this format, shorter or longer than its header tells, or
        its own mean wind is not positive at some height.
    """
    source = Path(path)
    try:
        with source.open("rb") as stream:
            head = _read_header(source, stream)
            velocity = _read_velocity(source, stream, head)
    except OSError as error:
        raise WindFieldError(f"{source}: cannot be read ({error.strerror})") from error
    y = (np.arange(head.ny, dtype=np.float64) - 0.5 * (head.ny - 1)) * head.dy
    z = head.bottom + np.arange(head.nz, dtype=np.float64) * head.dz
    if vertical is None:
        # in double precision: thousands of steps
        profile = velocity[..., 0].mean(axis=(0, 1), dtype=np.float64)
        if profile.min() <= 0.0:
            raise WindFieldError(
                f"{source}: got a mean wind of {profile.min():g} m/s at a height of "
                f"{z[profile.argmin()]:g} m; must be positive, or `vertical` be given"
            )
        vertical = TableShear(height=z, speed=profile)
    velocity[..., 0] -= head.mean_speed * vertical.factor(z, head.reference_height)
    spacing = head.mean_speed * head.dt
    box = TurbulenceBox(
        velocity=velocity,
        y=y,
        z=z,
        spacing=spacing,
        mean_speed=head.mean_speed,
        periodic=head.periodic,
        offset=_start(y, spacing, head.periodic),
        label=f"TurbSim, {source.name}",
    )
    return TurbSimWind(
        box=box,
        vertical=vertical,
        reference_height=head.reference_height,
        description=head.description,
    )


def write_bts(
    path: str | os.PathLike[str], field: TurbulentField, *, description: str = ""
) -> None:
    """Write the wind of a field without the tower, which OpenFAST adds itself.

    Velocities are rounded to one of 65534 levels between the least and the largest of their
    component, coordinates to single precision. The file is written whole or not at all.

    Parameters
    ----------
    field : TurbulentField
        With a `TurbulenceBox` whose y is centred and whose `offset` is InflowWind's (see the
        module), in a mean wind along x.
    description : str
        ASCII, at most 200 characters; empty: the box's label.

    Raises
    ------
    WindFieldError
        If the field cannot be said in this format, or the file cannot be written.
    """
    box, mean = field.box, field.mean
    if not isinstance(box, TurbulenceBox):
        raise WindFieldError("field: got a polar box; must be a Cartesian one for a .bts file")
    if mean.direction != 0.0:
        raise WindFieldError(
            f"direction: got {mean.direction:g} rad; must be 0 in a .bts file, InflowWind turns it "
            "(PropagationDir)"
        )
    dy, dz = ((a[-1] - a[0]) / (a.size - 1) for a in (box.y, box.z))
    if abs(box.y[0] + box.y[-1]) > SLACK * dy:
        raise WindFieldError(
            f"y: got {box.y[0]:g} to {box.y[-1]:g} m; must be centred at 0 in a .bts file"
        )
    start = _start(box.y, box.spacing, box.periodic)
    if abs(box.offset - start) > SLACK:
        raise WindFieldError(
            f"offset: got {box.offset:g} slices; must be {start:g} in a .bts file of a box that is "
            f"{'' if box.periodic else 'not '}periodic"
        )
    text = description or box.label
    if not text.isascii() or len(text) > LONGEST_TEXT:
        raise WindFieldError(
            f"description: got {text[:40]!r} of {len(text)} characters; must be ASCII, at most "
            f"{LONGEST_TEXT}"
        )
    added = np.zeros((box.y.size, box.z.size, 3))
    added[..., 0] = mean.undisturbed_speed(box.y[:, None], box.z)
    slope, offset = _levels(box.velocity, added)
    head = HEADER.pack(
        PERIODIC if box.periodic else STEADY_END,
        box.z.size, box.y.size, 0, len(box.velocity),
        dz, dy, box.interval, box.mean_speed, mean.hub_height, box.z[0],
        *np.column_stack([slope, offset]).ravel().tolist(),
        len(text),
    )  # fmt: skip

    def write(stream: BinaryIO) -> None:
        stream.write(head + text.encode("ascii"))
        step = _chunk(added.size)
        for k in range(0, len(box.velocity), step):
            counts = np.rint((box.velocity[k : k + step] + added) * slope + offset)
            stream.write(counts.astype("<i2").swapaxes(1, 2).tobytes())

    write_whole(Path(path), write)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Header:
    periodic: bool
    nz: int
    ny: int
    tower: int
    steps: int
    dz: float
    dy: float
    dt: float
    mean_speed: float
    reference_height: float
    bottom: float
    slope: NDArray[np.float32]
    offset: NDArray[np.float32]
    description: str


def _read_header(source: Path, stream: BinaryIO) -> _Header:
    size = os.fstat(stream.fileno()).st_size
    raw = stream.read(HEADER.size)
    if len(raw) < HEADER.size:
        raise WindFieldError(
            f"{source}: got {len(raw)} bytes; must be a TurbSim file, whose header has "
            f"{HEADER.size}"
        )
    kind, nz, ny, tower, steps, *numbers, length = HEADER.unpack(raw)
    if kind not in (STEADY_END, PERIODIC):
        raise WindFieldError(
            f"{source}: got identifier {kind}; must be a TurbSim full-field file, "
            f"{STEADY_END} or {PERIODIC}"
        )
    if min(nz, ny, steps) < 2 or min(tower, length) < 0:
        raise WindFieldError(
            f"{source}: got a grid of {ny} x {nz}, {tower} tower points, {steps} steps and a text "
            f"of {length} bytes; must be at least 2 x 2, 0, 2 and 0"
        )
    # the shortest decimal that is the same in single precision: 0.1, not 0.10000000149
    dz, dy, dt, speed, reference, bottom = (float(str(np.float32(v))) for v in numbers[:6])
    scales = np.array(numbers[6:], dtype=np.float32).reshape(3, 2)
    positive = np.array([dz, dy, dt, speed, reference])
    sound = np.isfinite(positive).all() and positive.min() > 0.0
    scaled = np.isfinite(scales).all() and scales[:, 0].all()
    if not (sound and scaled and 0.0 <= bottom < np.inf):
        raise WindFieldError(
            f"{source}: got dz = {dz:g}, dy = {dy:g} m, dt = {dt:g} s, mean speed {speed:g} m/s, "
            f"reference height {reference:g} m, lowest row {bottom:g} m, slopes "
            f"{scales[:, 0].tolist()}; must be finite, steps, speed and reference height "
            "positive, the lowest row >= 0, slopes not 0"
        )
    expected = HEADER.size + length + 6 * steps * (ny * nz + tower)
    if size != expected:
        raise WindFieldError(
            f"{source}: got {size} bytes; must be {expected} for {steps} steps of {ny} x {nz} grid "
            f"and {tower} tower points"
        )
    text = stream.read(length).decode("ascii", errors="replace").strip()
    return _Header(
        periodic=kind == PERIODIC, nz=nz, ny=ny, tower=tower, steps=steps, dz=dz, dy=dy, dt=dt,
        mean_speed=speed, reference_height=reference, bottom=bottom,
        slope=scales[:, 0], offset=scales[:, 1], description=text,
    )  # fmt: skip


def _read_velocity(source: Path, stream: BinaryIO, head: _Header) -> NDArray[np.float32]:
    grid = head.ny * head.nz
    velocity = np.empty((head.steps, head.ny, head.nz, 3), dtype=np.float32)
    width = 3 * (grid + head.tower)
    step = _chunk(width)
    for k in range(0, head.steps, step):
        count = min(step, head.steps - k)
        raw = stream.read(2 * count * width)
        if len(raw) < 2 * count * width:
            raise WindFieldError(f"{source}: ended while it was read")
        counts = np.frombuffer(raw, dtype="<i2").reshape(count, width)[:, : 3 * grid]
        counts = counts.reshape(count, head.nz, head.ny, 3).swapaxes(1, 2)
        velocity[k : k + count] = (counts - head.offset.astype(np.float64)) / head.slope
    return velocity


def _chunk(width: int) -> int:
    """Time steps of `width` numbers to handle at once."""
    return max(1, CHUNK // width)


def _start(y: FloatArray, spacing: float, periodic: bool) -> float:
    """Slice that InflowWind has at the tower axis at t = 0."""
    return 0.0 if periodic else float(0.5 * (y[-1] - y[0]) / spacing)


def _levels(
    velocity: NDArray[np.float32], added: FloatArray
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Slope and offset of the counts of u, v, w, in single precision as the file has them."""
    # the mean wind is the same for all slices, so the extremes at a point are those over time
    low = (velocity.min(axis=0) + added).min(axis=(0, 1))
    high = (velocity.max(axis=0) + added).max(axis=(0, 1))
    # a narrow range far from zero needs an offset that single precision cannot tell
    spread = np.maximum(high - low, NARROWEST * np.maximum(np.abs(low), np.abs(high)))
    slope32 = (COUNTS / np.where(spread > 0.0, spread, COUNTS)).astype(np.float32)
    return slope32, (LOWEST - slope32 * low).astype(np.float32)
