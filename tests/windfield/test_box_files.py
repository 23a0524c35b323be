"""Files of HAWC2 and TurbSim: round trips, conventions, and every kind of bad file."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from windfield import (
    PolarBox,
    PowerLaw,
    StaticField,
    TableShear,
    TowerShadow,
    TurbulenceBox,
    TurbulentField,
    WindFieldError,
    read_bts,
    read_hawc2,
    write_bts,
)

# --- HAWC2 ---

SHAPE = (16, 5, 4)
SPACING = (3.0, 10.0, 12.0)


@pytest.fixture
def hawc2(tmp_path: Path) -> tuple[list[Path], np.ndarray]:
    """Three files as a Mann generator writes them, and their content (3, Nx, Ny, Nz)."""
    values = np.random.default_rng(1).standard_normal((3, *SHAPE)).astype("<f4")
    paths = [tmp_path / f"box_{c}.bin" for c in "uvw"]
    for path, component in zip(paths, values, strict=True):
        component.tofile(path)
    return paths, values


def read(paths: list[Path], **changes: Any) -> TurbulenceBox:
    settings: dict[str, Any] = {
        "shape": SHAPE, "spacing": SPACING, "mean_speed": 12.0, "centre_height": 90.0,
    }  # fmt: skip
    return read_hawc2(*paths, **(settings | changes))


def test_hawc2_indices_as_inflowwind_has_them(hawc2: tuple[list[Path], np.ndarray]) -> None:
    paths, values = hawc2
    box = read(paths)
    # i = ((U t - x) / dx) mod Nx, j = (half width - y) / dy, k = (z - bottom) / dz
    for x, y, z, t in ((0.0, 20.0, 72.0, 0.0), (-5.0, -20.0, 108.0, 1.0), (6.0, 10.0, 84.0, 70.5)):
        i, j, k = ((12.0 * t - x) / 3.0) % 16, (20.0 - y) / 10.0, (z - 72.0) / 12.0
        assert j == int(j) and k == int(k)
        low, share = int(i), i - int(i)
        wanted = (1 - share) * values[:, low, int(j), int(k)].astype(np.float64)
        wanted += share * values[:, (low + 1) % 16, int(j), int(k)].astype(np.float64)
        np.testing.assert_allclose(box.fluctuation(x, y, z, t), wanted, atol=1e-6)
    assert box.label == "HAWC2, box_u.bin" and box.periodic


@pytest.mark.parametrize("size", [0, 1276, 1284])
def test_hawc2_files_of_another_size(hawc2: tuple[list[Path], np.ndarray], size: int) -> None:
    path = hawc2[0][1]
    path.write_bytes((path.read_bytes() * 2)[:size])
    with pytest.raises(WindFieldError, match=rf"box_v\.bin: got {size} bytes; must be 1280"):
        read(hawc2[0])


def test_bad_hawc2_files(hawc2: tuple[list[Path], np.ndarray], tmp_path: Path) -> None:
    paths, values = hawc2
    with pytest.raises(WindFieldError, match=r"u.bin: got 1280 bytes; must be 1536, .* 16 x 6 x 4"):
        read(paths, shape=(16, 6, 4))
    with pytest.raises(WindFieldError, match=r"none.bin: cannot be read \(No such file"):
        read([paths[0], paths[1], tmp_path / "none.bin"])
    values[2, 3, 2, 1] = np.nan
    values[2].tofile(paths[2])
    with pytest.raises(WindFieldError, match=r"w\.bin: got NaN"):
        read(paths)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shape": (16, 5)}, "shape: got"),
        ({"shape": (16, 5, 1)}, "shape: got 1"),
        ({"spacing": (1.0, 2.0, 0.0)}, "spacing: got 0"),
        ({"spacing": (1.0, 2.0)}, "spacing: got"),
        ({"mean_speed": 0.0}, "mean_speed: got 0"),
        ({"centre_height": 10.0}, "z: got -8 m"),
    ],
)
def test_bad_hawc2_settings(
    hawc2: tuple[list[Path], np.ndarray], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(WindFieldError, match=message):
        read(hawc2[0], **changes)


# --- TurbSim ---

NX, NY, NZ = 12, 4, 5
BOX = TurbulenceBox(
    velocity=np.random.default_rng(2).normal(0.0, [1.5, 1.2, 0.8], (NX, NY, NZ, 3)),
    y=np.linspace(-30.0, 30.0, NY),
    z=np.linspace(60.0, 120.0, NZ),
    spacing=0.6,
    mean_speed=12.0,
    periodic=True,
    label="made up",
)
ENDING = replace(BOX, periodic=False, offset=50.0)
MEAN = StaticField(speed=12.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2))
FIELD = TurbulentField(mean=MEAN, box=BOX)


def raw_bts(
    counts: np.ndarray, *, kind: int = 8, tower: int = 0, scales: tuple[float, ...] = (),
    header: dict[int, Any] | None = None,
) -> bytes:  # fmt: skip
    """File written from the description of the format, point by point; counts (Nt, Nz, Ny, 3)."""
    nt, nz, ny, _ = counts.shape
    text = b"by hand"
    values = [kind, nz, ny, tower, nt, 15.0, 20.0, 0.05, 12.0, 90.0, 60.0]
    values += [*(scales or (1000.0, -12000.0, 2000.0, 0.0, 4000.0, 10.0)), len(text)]
    for index, value in (header or {}).items():
        values[index] = value
    out = [struct.pack("<h4l6f6fl", *values), text]
    for step in counts:
        out += [struct.pack("<3h", *step[k, j]) for k in range(nz) for j in range(ny)]
        out += [struct.pack("<3h", 7, 7, 7) for _ in range(tower)]
    return b"".join(out)


COUNTS = np.random.default_rng(3).integers(-3000, 3000, (NX, NZ, NY, 3), dtype=np.int16)


@pytest.mark.parametrize("tower", [0, 3])
def test_bts_as_the_format_is_described(tmp_path: Path, tower: int) -> None:
    path = tmp_path / "wind.bts"
    path.write_bytes(raw_bts(COUNTS, tower=tower))
    got = read_bts(path, vertical=PowerLaw(exponent=0.0))
    box = got.box
    np.testing.assert_allclose(box.y, [-30.0, -10.0, 10.0, 30.0])
    np.testing.assert_allclose(box.z, [60.0, 75.0, 90.0, 105.0, 120.0])
    assert (box.interval, box.mean_speed, box.periodic) == (pytest.approx(0.05), 12.0, True)
    assert (got.reference_height, got.description) == (90.0, "by hand")
    for i, j, k in ((0, 0, 0), (3, 1, 4), (11, 3, 2)):
        raw = COUNTS[i, k, j].astype(np.float64)
        wanted = [(raw[0] + 12000) / 1000 - 12.0, raw[1] / 2000, (raw[2] - 10) / 4000]
        np.testing.assert_allclose(box.velocity[i, j, k], wanted, atol=2e-6)


@pytest.mark.parametrize("box", [BOX, ENDING], ids=["periodic", "ending"])
def test_bts_round_trip_within_half_a_count(tmp_path: Path, box: TurbulenceBox) -> None:
    path = tmp_path / "wind.bts"
    field = TurbulentField(mean=MEAN, box=box)
    write_bts(path, field)
    got = read_bts(path, vertical=MEAN.vertical)
    total = box.velocity.astype(np.float64)
    total[..., 0] += MEAN.undisturbed_speed(0.0, box.z)
    half = 0.5 * np.ptp(total, axis=(0, 1, 2)) / 65533
    error = np.abs(got.box.velocity - box.velocity).max(axis=(0, 1, 2))
    assert (error < 1.001 * half + 2e-6).all()  # and single precision at 15 m/s
    assert (error > 0.5 * half).all()  # the counts are used
    assert got.description == "made up" and got.box.label == "TurbSim, wind.bts"
    for name in ("spacing", "mean_speed", "offset", "periodic"):
        assert getattr(got.box, name) == pytest.approx(getattr(box, name), rel=1e-12), name


@pytest.mark.parametrize("box", [BOX, ENDING], ids=["periodic", "ending"])
def test_field_of_a_file_is_what_inflowwind_interpolates(
    tmp_path: Path, box: TurbulenceBox
) -> None:
    path = tmp_path / "wind.bts"
    write_bts(path, TurbulentField(mean=MEAN, box=box))
    field = read_bts(path).field()
    total = box.velocity.astype(np.float64)
    total[..., 0] += MEAN.undisturbed_speed(0.0, box.z)
    rng = np.random.default_rng(4)
    for _ in range(30):
        x, y, z = rng.uniform(25.0, 29.0), rng.uniform(-30, 30), rng.uniform(60, 120)
        t = rng.uniform(0.0, 0.1)
        # time is shifted by half the grid width over U unless the file is periodic
        at = (t + ((0.0 if box.periodic else 30.0) - x) / 12.0) / 0.05
        at = at % NX if box.periodic else at
        j, k = (y + 30.0) / 20.0, (z - 60.0) / 15.0
        wanted = np.zeros(3)
        for i, p in ((int(at), 1 - at % 1), (int(at) + 1, at % 1)):
            for jj, q in ((int(j), 1 - j % 1), (int(j) + 1, j % 1)):
                for kk, r in ((int(k), 1 - k % 1), (int(k) + 1, k % 1)):
                    wanted += p * q * r * total[i % NX, jj, kk]
        np.testing.assert_allclose(field.velocity(x, y, z, t), wanted, atol=2e-4)


def test_own_mean_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "wind.bts"
    write_bts(path, FIELD)
    got = read_bts(path)
    assert isinstance(got.vertical, TableShear)
    total = BOX.velocity[..., 0] + MEAN.undisturbed_speed(0.0, BOX.z)
    profile = total.mean(axis=(0, 1))
    np.testing.assert_allclose(got.vertical.factor(BOX.z, 90.0), profile / profile[2], rtol=2e-5)
    left = got.box.velocity[..., 0].mean(axis=(0, 1))
    np.testing.assert_allclose(left, (profile[2] - 12.0) * profile / profile[2], atol=1e-4)
    assert abs(profile[2] - 12.0) > 0.01  # else the line above says nothing
    tower = TowerShadow(radius=2.0, top=88.0)
    with_tower = got.field(tower).velocity(-6.0, 0.0, 70.0, 1.0)
    plain = got.field().velocity(-6.0, 0.0, 70.0, 1.0)
    assert with_tower[0] == pytest.approx(plain[0] * (1 - 4.0 / 36.0))


def test_components_without_spread(tmp_path: Path) -> None:
    path = tmp_path / "wind.bts"
    velocity = np.zeros((NX, NY, NZ, 3))
    velocity[..., 1] = 1e-9 * np.arange(NX)[:, None, None]
    velocity[..., 2] = -2.0
    uniform = StaticField(speed=12.0, hub_height=90.0)
    write_bts(path, TurbulentField(mean=uniform, box=replace(BOX, velocity=velocity)))
    got = read_bts(path, vertical=PowerLaw(exponent=0.0)).box.velocity
    assert np.abs(got[..., 0]).max() < 1e-6 * 12.0
    np.testing.assert_allclose(got[..., 1], velocity[..., 1], atol=1e-13)
    np.testing.assert_allclose(got[..., 2], -2.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (replace(FIELD, mean=replace(MEAN, direction=0.1)), "direction: got 0.1"),
        (replace(FIELD, box=replace(BOX, offset=1.0)), "offset: got 1 slices; must be 0"),
        (replace(FIELD, box=replace(ENDING, offset=0.0)), "must be 50 .* is not periodic"),
        (replace(FIELD, box=replace(BOX, y=BOX.y + 1.0)), "y: got -29 to 31 m"),
        (
            replace(FIELD, box=PolarBox(
                velocity=np.zeros((4, 3, 5, 3)), radius=[0.0, 1.0, 2.0], centre_height=90.0,
                spacing=1.0, mean_speed=12.0,
            )),
            "polar box",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_said_in_a_bts_file(
    tmp_path: Path, field: TurbulentField, message: str
) -> None:
    with pytest.raises(WindFieldError, match=message):
        write_bts(tmp_path / "wind.bts", field)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["x" * 201, "Höhe"])
def test_bad_descriptions(tmp_path: Path, text: str) -> None:
    with pytest.raises(WindFieldError, match="description: got"):
        write_bts(tmp_path / "wind.bts", FIELD, description=text)


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(WindFieldError, match="cannot be written"):
        write_bts(tmp_path / "none" / "wind.bts", FIELD)


def change(index: int, value: Any) -> Callable[[], bytes]:
    return lambda: raw_bts(COUNTS, header={index: value})


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda: b"", "got 0 bytes; must be a TurbSim file"),
        (lambda: raw_bts(COUNTS)[:60], "got 60 bytes"),
        (lambda: raw_bts(COUNTS)[:-2], r"got 1515 bytes; must be 1517 for 12 steps of 4 x 5"),
        (lambda: raw_bts(COUNTS) + b"xx", "got 1519 bytes; must be 1517"),
        (lambda: b"%PDF-1.4" + bytes(300), "got identifier 20517"),
        (change(0, 4), "got identifier 4; must be a TurbSim full-field file, 7 or 8"),
        (change(1, 1), "grid of 4 x 1"),
        (change(2, -4), "grid of -4 x 5"),
        (change(3, -1), "-1 tower points"),
        (change(4, 2**30), "must be .* for 1073741824 steps"),
        (change(5, 0.0), "dz = 0"),
        (change(7, float("nan")), "dt = nan s"),
        (change(8, -12.0), "mean speed -12 m/s"),
        (change(10, float("inf")), "lowest row inf"),
        (change(10, -1.0), "lowest row -1 m"),
        (change(11, 0.0), r"slopes \[0.0"),
        (change(17, -7), "text of -7 bytes"),
        (lambda: raw_bts(COUNTS, scales=(1e3, 0.0) * 3), "mean wind of -?0.* m/s at a height"),
    ],
)
def test_bad_bts_files(tmp_path: Path, content: Callable[[], bytes], message: str) -> None:
    path = tmp_path / "wind.bts"
    path.write_bytes(content())
    with pytest.raises(WindFieldError, match=message):
        read_bts(path)


def test_a_bts_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(WindFieldError, match=r"wind.bts: cannot be read \(No such file"):
        read_bts(tmp_path / "wind.bts")
    with pytest.raises(WindFieldError, match="cannot be read"):
        read_bts(tmp_path)


# --- shear from a table ---


def test_table_shear() -> None:
    shear = TableShear(height=[20.0, 60.0, 100.0], speed=[6.0, 10.0, 12.0])
    np.testing.assert_allclose(
        shear.factor([0.0, 20.0, 40.0, 80.0, 300.0], 80.0), np.array([6, 6, 8, 11, 12]) / 11.0
    )
    field = StaticField(speed=9.0, hub_height=80.0, vertical=shear)
    assert field.velocity(0.0, 0.0, 80.0)[0] == pytest.approx(9.0)
    assert shear == TableShear(height=[20.0, 60.0, 100.0], speed=[6.0, 10.0, 12.0])


@pytest.mark.parametrize(
    ("height", "speed", "message"),
    [
        ([20.0], [6.0], "at least 2"),
        ([20.0, 30.0], [6.0, 7.0, 8.0], r"got shapes \(2,\) and \(3,\)"),
        ([20.0, 20.0], [6.0, 7.0], "must increase"),
        ([-1.0, 20.0], [6.0, 7.0], "got -1 m"),
        ([1.0, 20.0], [6.0, -7.0], "-7 m/s"),
    ],
)
def test_bad_tables_of_shear(height: list[float], speed: list[float], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        TableShear(height=height, speed=speed)


def test_table_without_wind_at_the_hub() -> None:
    with pytest.raises(WindFieldError, match="speed of 0"):
        TableShear(height=[0.0, 60.0, 100.0], speed=[0.0, 0.0, 7.0]).factor(80.0, 50.0)
