"""Sampling over the disc, CSV round trip and every kind of bad file."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from windfield import (
    CallableField,
    DiscField,
    DiscSample,
    PowerLaw,
    StaticField,
    TowerShadow,
    WindFieldError,
    disc_points,
    sample_disc,
)
from windfield.discfile import MAX_BYTES

FIELD = StaticField(
    speed=12.0,
    hub_height=90.0,
    vertical=PowerLaw(exponent=0.2),
    horizontal_shear=1e-3,
    tower=TowerShadow(radius=2.0, top=87.6),
)


class TestSampling:
    def test_points(self) -> None:
        radii, azimuth, y, z = disc_points(40.0, rings=5, azimuths=8)
        np.testing.assert_array_equal(radii, [0.0, 10.0, 20.0, 30.0, 40.0])
        np.testing.assert_allclose(np.rad2deg(azimuth), np.arange(0, 360, 45))
        assert y.shape == z.shape == (5, 8)
        np.testing.assert_allclose(np.hypot(y, z), np.broadcast_to(radii[:, None], y.shape))
        # blade up, right, down, left looking downwind
        np.testing.assert_allclose(y[-1, ::2], [0.0, -40.0, 0.0, 40.0], atol=1e-13)
        np.testing.assert_allclose(z[-1, ::2], [40.0, 0.0, -40.0, 0.0], atol=1e-13)

    def test_annulus_and_closed(self) -> None:
        radii, azimuth, y, _ = disc_points(40.0, rings=3, azimuths=6, inner_radius=8.0, closed=True)
        np.testing.assert_array_equal(radii, [8.0, 24.0, 40.0])
        assert azimuth.size == 7 and azimuth[-1] == 2 * np.pi and y.shape == (3, 7)

    def test_sample_is_the_field_at_the_points(self) -> None:
        sample = sample_disc(FIELD, 63.0, x=-5.0, rings=6, azimuths=9)
        velocity = FIELD.velocity(-5.0, sample.y, 90.0 + sample.z)
        np.testing.assert_allclose(sample.speed, np.linalg.norm(velocity, axis=-1))
        for k, component in enumerate(("downwind", "lateral", "vertical")):
            part = sample_disc(FIELD, 63.0, x=-5.0, rings=6, azimuths=9, component=component)
            np.testing.assert_array_equal(part.speed, velocity[..., k])
            assert part != sample

    def test_field_without_hub_height(self) -> None:
        class Bare:
            def velocity(self, *points: object) -> object:
                return np.zeros((*np.broadcast_shapes(*map(np.shape, points)), 3))

        bare = Bare()
        with pytest.raises(WindFieldError, match="hub_height: got None and Bare has none"):
            sample_disc(bare, 40.0)
        assert sample_disc(bare, 40.0, hub_height=80.0).hub_height == 80.0

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"radius": 0.0}, "radius: got 0.0"),
            ({"radius": math.nan}, "radius: got nan"),
            ({"rings": 1}, "rings: got 1; must be a whole number >= 2"),
            ({"rings": 2.5}, "rings: got 2.5"),
            ({"azimuths": 2}, "azimuths: got 2; must be a whole number >= 3"),
            ({"azimuths": True}, "azimuths: got True"),
            ({"inner_radius": 40.0}, "inner_radius: got 40 m; must be below radius"),
            ({"inner_radius": -1.0}, "inner_radius: got -1.0"),
            ({"component": "upwind"}, "component: got 'upwind'"),
            ({"hub_height": -1.0}, "hub_height: got -1.0"),
            ({"hub_height": 20.0}, "below ground"),
            ({"x": math.inf}, "x: got inf"),
            ({"t": math.nan}, "t: got nan"),
        ],
    )
    def test_bad_input(self, arguments: dict[str, object], message: str) -> None:
        with pytest.raises(WindFieldError, match=message):
            sample_disc(FIELD, **{"radius": 40.0, **arguments})

    def test_sample_is_a_checked_value(self) -> None:
        with pytest.raises(WindFieldError, match=r"speed: got shape \(2, 2\); must be \(2, 3\)"):
            DiscSample(
                radius=np.arange(2.0), azimuth=np.arange(3.0), speed=np.ones((2, 2)),
                hub_height=90.0,
            )  # fmt: skip
        sample = sample_disc(FIELD, 40.0)
        assert sample == sample_disc(FIELD, 40.0)
        with pytest.raises(ValueError, match="read-only"):
            sample.speed[0, 0] = 1.0


class TestRoundTrip:
    @pytest.mark.parametrize("closed", [False, True])
    def test_polar(self, tmp_path: Path, closed: bool) -> None:
        sample = sample_disc(FIELD, 63.0, x=-5.0, rings=7, azimuths=15, closed=closed)
        path = tmp_path / "disc.csv"
        sample.to_csv(path)
        assert path.read_text().splitlines()[0] == "radius,azimuth_deg,speed"
        back = DiscField.from_csv(path, hub_height=90.0)
        np.testing.assert_allclose(
            back.undisturbed_speed(sample.y, 90.0 + sample.z), sample.speed, rtol=1e-12
        )
        assert [p.name for p in tmp_path.iterdir()] == ["disc.csv"]

    def test_of_a_file_at_another_hub_height(self, tmp_path: Path) -> None:
        path = tmp_path / "disc.csv"
        sample_disc(FIELD, 40.0).to_csv(path)
        low, high = (DiscField.from_csv(path, hub_height=h) for h in (90.0, 150.0))
        assert low.undisturbed_speed(3.0, 95.0) == high.undisturbed_speed(3.0, 155.0)
        turned = DiscField.from_csv(path, hub_height=90.0, direction=0.5, tower=FIELD.tower)
        assert turned.direction == 0.5 and turned.tower == FIELD.tower

    @given(st.lists(st.floats(0.0, 50.0), min_size=6, max_size=6))
    def test_values_are_kept_exactly(
        self, tmp_path_factory: pytest.TempPathFactory, values: list[float]
    ) -> None:
        sample = DiscSample(
            radius=np.array([5.0, 40.0]), azimuth=np.deg2rad([0.0, 120.0, 240.0]),
            speed=np.reshape(values, (2, 3)), hub_height=90.0,
        )  # fmt: skip
        path = tmp_path_factory.getbasetemp() / "exact.csv"
        sample.to_csv(path)
        np.testing.assert_array_equal(DiscField.from_csv(path, hub_height=90).speed, sample.speed)

    def test_cartesian_in_any_order(self, tmp_path: Path) -> None:
        rows = [(s, z, y) for y in (-50, 0, 50) for z in (-60.0, 60.0) for s in [10 + y / 50 + z]]
        rng = np.random.default_rng(12)
        text = "\ufeff# a comment\n\n Speed , Z,y\r\n" + "\r\n".join(
            ",".join(map(str, (abs(r[0]), r[1], r[2]))) for r in rng.permutation(rows).tolist()
        )
        path = tmp_path / "disc.csv"
        path.write_text(text + "\n\n", encoding="utf-8")
        field = DiscField.from_csv(path, hub_height=90.0)
        np.testing.assert_array_equal(field.y, [-50, 0, 50])
        np.testing.assert_array_equal(field.speed, [[51, 69], [50, 70], [49, 71]])

    def test_overwrites_whole_or_not_at_all(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        path = tmp_path / "disc.csv"
        path.write_text("old")
        sample = sample_disc(FIELD, 40.0)

        def full(*args: object, **kwargs: object) -> None:
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(Path, "replace", full)
            with pytest.raises(WindFieldError, match=r"cannot be written \(No space left"):
                sample.to_csv(path)
        assert path.read_text() == "old"
        assert list(tmp_path.iterdir()) == [path]
        sample.to_csv(path)
        assert path.read_text().startswith("radius")

    def test_cannot_be_written(self, tmp_path: Path) -> None:
        sample = sample_disc(FIELD, 40.0)
        with pytest.raises(WindFieldError, match="cannot be written"):
            sample.to_csv(tmp_path / "absent" / "disc.csv")
        (tmp_path / "folder").mkdir()
        with pytest.raises(WindFieldError, match="cannot be written"):
            sample.to_csv(tmp_path / "folder")
        with pytest.raises(WindFieldError, match="must name a file"):
            sample.to_csv("")
        assert [p.name for p in tmp_path.iterdir()] == ["folder"]
        lateral = sample_disc(FIELD, 40.0, component="lateral")
        with pytest.raises(WindFieldError, match="component: got 'lateral'; must be 'speed'"):
            lateral.to_csv(tmp_path / "disc.csv")


GOOD = "y,z,speed\n-1,-1,8\n-1,1,9\n1,-1,8\n1,1,9\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "file is empty"),
        ("\n \n# only a comment\n", "file is empty"),
        ("y,z,speed\n", "header without rows"),
        ("x,z,speed\n1,2,3\n", "got header 'x,z,speed'; must be 'y,z,speed' or 'radius,"),
        ("y,z\n1,2\n", "got header 'y,z'"),
        ("y,z,speed,note\n1,2,3,4\n", "got header"),
        ("y;z;speed\n1;2;3\n", "got header 'y;z;speed'"),
        ("1,2,3\n4,5,6\n", "got header '1,2,3'"),
        ("radius,azimuth,speed\n1,2,3\n", "got header"),
        (GOOD.replace("1,1,9", "1,1"), "line 3: got '-1,1'; must be three finite numbers"),
        (GOOD + "1,2,3,4\n", "line 6: got '1,2,3,4'"),
        (GOOD + "1,2,fast\n", "line 6: got '1,2,fast'"),
        (GOOD + "1,2,\n", "line 6"),
        (GOOD.replace("9", "nan"), "line 3: got '-1,1,nan'; must be three finite"),
        (GOOD.replace("-1,-1,8", "-1,-1,inf"), "line 2: .*three finite"),
        (GOOD.replace("9", "1e999"), "line 3: .*three finite"),
        (GOOD.replace("9", "-9"), r"got speed -9; must be >= 0 \[m/s\]"),
        (GOOD + "1,1,9\n", r"got \(y, z\) = \(1, 1\) 2 times"),
        (GOOD[:-6], r"got 3 of the 4 points of a 2 x 2 grid, \(y, z\) = \(1, 1\) is missing"),
        (GOOD.replace("-1,1,9\n", ""), r"\(y, z\) = \(-1, 1\) is missing"),
        ("y,z,speed\n1,1,8\n1,2,9\n", r"y: got 1 value\(s\); must be at least 2"),
        ("radius,azimuth_deg,speed\n" + "".join(
            f"{r},{a},9\n" for r in (1, 2) for a in (0, 10, 20)), "a gap of 340 degrees"),
        ("radius,azimuth_deg,speed\n" + "".join(
            f"{r},{a},9\n" for r in (-1, 2) for a in (0, 90, 180, 270)), "radius: got -1"),
    ],
)  # fmt: skip
def test_bad_content(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "disc.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(WindFieldError, match=message) as caught:
        DiscField.from_csv(path, hub_height=90.0)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_good_content_is_good(tmp_path: Path) -> None:
    path = tmp_path / "disc.csv"
    path.write_text(GOOD)
    field = DiscField.from_csv(str(path), hub_height=90.0)
    assert field.undisturbed_speed(0.0, 90.0) == 8.5


@pytest.mark.parametrize("raw", [bytes(range(256)), b"y,z,speed\n1,\x00,3\n", b"\x89PNG\r\n\xff"])
def test_binary_file(tmp_path: Path, raw: bytes) -> None:
    path = tmp_path / "disc.csv"
    path.write_bytes(raw)
    with pytest.raises(WindFieldError, match="got a binary file; must be a CSV text file"):
        DiscField.from_csv(path, hub_height=90.0)


def test_huge_file(tmp_path: Path) -> None:
    path = tmp_path / "disc.csv"
    path.touch()
    os.truncate(path, MAX_BYTES + 1)  # sparse: takes no space
    with pytest.raises(WindFieldError, match=r"got a file of 16\.0 MiB; must be at most 16 MiB"):
        DiscField.from_csv(path, hub_height=90.0)


def test_scattered_points_need_no_memory(tmp_path: Path) -> None:
    # 30 000 points without a common grid would fill a table of 7 GB
    points = np.random.default_rng(13).uniform(-50, 50, (30_000, 2))
    path = tmp_path / "disc.csv"
    path.write_text("y,z,speed\n" + "".join(f"{a!r},{b!r},9\n" for a, b in points.tolist()))
    with pytest.raises(WindFieldError, match="got 30000 of the 900000000 points"):
        DiscField.from_csv(path, hub_height=90.0)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(WindFieldError, match="got no such file; must be a CSV file"):
        DiscField.from_csv(tmp_path / "absent.csv", hub_height=90.0)
    with pytest.raises(WindFieldError, match="got a folder or device"):
        DiscField.from_csv(tmp_path, hub_height=90.0)


def test_sampled_function_can_be_designed_on(tmp_path: Path) -> None:
    smooth = CallableField(speed=lambda y, z: 12 + 0.02 * z - 0.01 * y, hub_height=90.0)
    path = tmp_path / "disc.csv"
    sample_disc(smooth, 60.0, rings=31, azimuths=72).to_csv(path)
    grid = DiscField.from_csv(path, hub_height=90.0)
    y, z = np.random.default_rng(14).uniform(-40, 40, (2, 200))
    np.testing.assert_allclose(
        grid.velocity(-4.0, y, 90 + z), smooth.velocity(-4.0, y, 90 + z), atol=2e-3
    )
