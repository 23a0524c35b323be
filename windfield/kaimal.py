"""Boxes of turbulence with the Kaimal spectra and exponential coherence of IEC 61400-1.

The velocity of component k at point p is a sum over the frequencies f_n = n / T, T the length
of the box in time,

    u_kp(t) = sum_n sqrt(s_kn) [a_kpn cos(2 pi f_n t) - b_kpn sin(2 pi f_n t)],
    s_kn = int S_k over f_n +- 1 / (2 T),

with a and b standard normal, independent of each other and over k and n, and correlated over
the points by the coherence at f_n (`windfield.correlated`). The box is periodic in time, each
component has no mean at any point. Amplitudes are random like the phases, so that the
velocities are Gaussian and their periodogram is chi-squared about s.

What a box holds is the part of the spectrum between 1 / (2 T) and half the sampling frequency:
for u at 12 m/s, 660 s and 10 Hz about 91 % of the variance, slow variations are what is missing.
`scaling` says what becomes of that:

    "expectation"   one factor for each component, so that the expected variance at any point is
                    sigma_k^2; a single box has more or less
    "box"           one factor for each component and box, so that the variance in time, averaged
                    over the points, is sigma_k^2 in this very box
    "spectrum"      no factor: the expected spectrum is the standard's

Same settings and seed give the same box; the number of threads of the linear algebra may change
the rounding of float64, and with it the last bit of a velocity.

Left out: correlation between u and w (Reynolds stress), coherence that depends on height, and
spectra that do. The standard's model has none of them.

Reference: IEC 61400-1 (see `windfield.iec`); P. S. Veers, SAND88-0152, 1988, whose amplitudes
are not random.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from windfield._checks import FloatArray, as_count, as_number
from windfield.boxes import PolarBox, TurbulenceBox
from windfield.cache import BoxCache
from windfield.correlated import CartesianNoise, GridNoise, PolarNoise
from windfield.errors import WindFieldError
from windfield.iec import band_variance, coherence, iec_sigma

__all__ = ["Coupled", "Scaling", "kaimal_box", "kaimal_polar_box"]

Scaling = Literal["expectation", "box", "spectrum"]
Coupled = Literal["uvw", "u"]

RESOLUTION = 2.0**-24  # of velocities in single precision: less coherence than this is none
CHUNK = 2**22  # numbers in the tables of one chunk of frequencies


def kaimal_box(
    mean_speed: float,
    duration: float,
    interval: float,
    *,
    hub_height: float,
    width: float,
    height: float | None = None,
    points: tuple[int, int] = (13, 13),
    turbulence: str | float = "B",
    seed: int | np.random.Generator,
    scaling: Scaling = "expectation",
    coupled: Coupled = "uvw",
    cache: BoxCache | None = None,
) -> TurbulenceBox:
    """Box of Kaimal turbulence on a Cartesian grid centred at the hub, periodic in time.

    Parameters
    ----------
    mean_speed : float
        U at hub height [m/s], positive.
    duration, interval : float
        Least length in time, and time between slices [s].
    hub_height : float
        [m], positive; sets the length scales too.
    width, height : float
        Extent of the grid across and upward [m], from its first to its last point; a height of
        None is the width. The grid must stand above ground.
    points : (int, int)
        Grid points across and upward, at least two each.
    turbulence : {"A+", "A", "B", "C"} or float
        Class, with the normal turbulence model; or the intensity sigma_1 / U [-].
    seed : int or Generator
    scaling : {"expectation", "box", "spectrum"}
        What sigma is met by; see the module.
    coupled : {"uvw", "u"}
        Components whose points are correlated. "u": v and w of different points have nothing in
        common, as in TurbSim's IEC models.
    cache : BoxCache or None
        Where boxes are kept; needs a whole number as seed.

    Raises
    ------
    WindFieldError
        If a value is out of range.
    """
    across = as_number("width", width, "m", above=0.0)
    upward = across if height is None else as_number("height", height, "m", above=0.0)
    hub = as_number("hub_height", hub_height, "m", above=0.0)
    if upward > 2.0 * hub:
        raise WindFieldError(
            f"height: got {upward:g} m about hub_height = {hub:g} m; must be at most twice that, "
            "the grid stands above ground"
        )
    if len(points) != 2:
        raise WindFieldError(f"points: got {points!r}; must be two whole numbers")
    count = tuple(as_count("points", n, at_least=2) for n in points)
    spectrum = _Spectrum(
        mean_speed=mean_speed,
        duration=duration,
        interval=interval,
        hub_height=hub,
        turbulence=turbulence,
        seed=seed,
        scaling=scaling,
        coupled=coupled,
    )
    step = across / (count[0] - 1), upward / (count[1] - 1)
    noise = CartesianNoise((count[0], count[1]), step)
    grid: dict[str, object] = {"grid": "cartesian", "points": count, "extent": (across, upward)}
    return TurbulenceBox(
        velocity=spectrum.velocity(noise, grid, cache),
        y=np.linspace(-0.5 * across, 0.5 * across, count[0]),
        z=hub + np.linspace(-0.5 * upward, 0.5 * upward, count[1]),
        spacing=spectrum.speed * spectrum.interval,
        mean_speed=spectrum.speed,
        periodic=True,
        label=spectrum.label,
    )


def kaimal_polar_box(
    mean_speed: float,
    duration: float,
    interval: float,
    *,
    hub_height: float,
    radius: float,
    rings: int = 11,
    spokes: int = 24,
    turbulence: str | float = "B",
    seed: int | np.random.Generator,
    scaling: Scaling = "expectation",
    coupled: Coupled = "uvw",
    cache: BoxCache | None = None,
) -> PolarBox:
    """Box of Kaimal turbulence on rings and spokes about the hub, periodic in time.

    Parameters
    ----------
    radius : float
        Of the outermost ring [m], positive; at most the hub height.
    rings, spokes : int
        Rings, the centre being the first, at least two; spokes, at least three. In the mean
        over the points that `scaling="box"` takes, each counts once and the centre once.
    mean_speed, duration, interval, hub_height, turbulence, seed, scaling, coupled, cache
        As in `kaimal_box`.

    Raises
    ------
    WindFieldError
        If a value is out of range.
    """
    hub = as_number("hub_height", hub_height, "m", above=0.0)
    rim = as_number("radius", radius, "m", above=0.0)
    if rim > hub:
        raise WindFieldError(
            f"radius: got {rim:g} m about hub_height = {hub:g} m; must be at most that, the grid "
            "stands above ground"
        )
    radii = np.linspace(0.0, rim, as_count("rings", rings, at_least=2))
    number = as_count("spokes", spokes, at_least=3)
    spectrum = _Spectrum(
        mean_speed=mean_speed,
        duration=duration,
        interval=interval,
        hub_height=hub,
        turbulence=turbulence,
        seed=seed,
        scaling=scaling,
        coupled=coupled,
    )
    grid: dict[str, object] = {"grid": "polar", "points": (radii.size, number), "extent": rim}
    return PolarBox(
        velocity=spectrum.velocity(PolarNoise(radii, number), grid, cache),
        radius=radii,
        centre_height=hub,
        spacing=spectrum.speed * spectrum.interval,
        mean_speed=spectrum.speed,
        periodic=True,
        label=spectrum.label,
    )


class _Spectrum:
    """Checked settings that do not depend on the grid, and the synthesis of a box from them."""

    def __init__(
        self,
        *,
        mean_speed: float,
        duration: float,
        interval: float,
        hub_height: float,
        turbulence: str | float,
        seed: int | np.random.Generator,
        scaling: str,
        coupled: str,
    ) -> None:
        self.speed = as_number("mean_speed", mean_speed, "m/s", above=0.0)
        length = as_number("duration", duration, "s", above=0.0)
        self.interval = as_number("interval", interval, "s", above=0.0)
        self.slices = math.ceil(length / self.interval * (1.0 - 1e-9))
        if self.slices < 4:
            raise WindFieldError(
                f"duration: got {length:g} s, {self.slices} interval(s) of {self.interval:g} s; "
                "must be at least 4 intervals"
            )
        self.hub = hub_height
        self.sigma = iec_sigma(turbulence, self.speed)
        for name, value, options in (
            ("scaling", scaling, get_args(Scaling)),
            ("coupled", coupled, get_args(Coupled)),
        ):
            if value not in options:
                raise WindFieldError(f"{name}: got {value!r}; must be one of {options}")
        self.scaling, self.coupled = scaling, coupled
        if not isinstance(seed, np.random.Generator):
            seed = as_count("seed", seed, at_least=0)
        self.seed = seed
        name = f"class {turbulence}" if isinstance(turbulence, str) else f"intensity {turbulence:g}"
        origin = f"seed {seed}" if isinstance(seed, int) else "a generator"
        self.label = f"Kaimal, {name}, {self.speed:g} m/s, {origin}"

    def velocity(
        self, noise: GridNoise, grid: dict[str, object], cache: BoxCache | None
    ) -> NDArray[np.float32]:
        """Velocities (Nx, n1, n2, 3) [m/s], from the cache if they are there."""
        if cache is None:
            return self._synthesis(noise)
        if not isinstance(self.seed, int):
            raise WindFieldError("seed: got a generator; must be a whole number with a cache")
        key = {
            "kind": "Kaimal",
            "slices": self.slices,
            "interval": self.interval,
            "mean_speed": self.speed,
            "hub_height": self.hub,
            "sigma": self.sigma,
            "scaling": self.scaling,
            "coupled": self.coupled,
            "seed": self.seed,
            **grid,
        }
        return cache.velocity(key, lambda: self._synthesis(noise))

    def _synthesis(self, noise: GridNoise) -> NDArray[np.float32]:
        n, points = self.slices, noise.points
        step = 1.0 / (n * self.interval)
        frequency: FloatArray = np.arange(1, n // 2 + 1, dtype=np.float64) * step
        variance = self._variance(frequency, step)
        generator = np.random.default_rng(self.seed)
        coefficients = np.zeros((frequency.size + 1, points, 3), dtype=np.complex128)
        chunk = max(1, CHUNK // (points * points))
        for k in range(0, frequency.size, chunk):
            part = frequency[k : k + chunk]
            white = generator.standard_normal((part.size, points, 6))
            drawn = self._correlated(noise, part, white)
            coefficients[k + 1 : k + 1 + part.size] = drawn[..., :3] + 1j * drawn[..., 3:]
        # a harmonic of amplitude c has the coefficient n c / 2, that at half the sampling
        # frequency n c
        coefficients[1:] *= 0.5 * n * np.sqrt(variance)[:, None, :]
        if n % 2 == 0:
            coefficients[-1] *= 2.0
        wind = np.fft.irfft(coefficients, n=n, axis=0)
        if self.scaling == "box":
            have = np.mean(wind**2, axis=(0, 1))
            wind *= np.sqrt(self._targets() / have)
        return noise.on_grid(wind.astype(np.float32))

    def _targets(self) -> FloatArray:
        return band_variance(
            0.0, 1e30, sigma=self.sigma, mean_speed=self.speed, hub_height=self.hub
        )

    def _variance(self, frequency: FloatArray, step: float) -> FloatArray:
        """Variance (K, 3) of each harmonic [(m/s)^2]."""
        edge = 0.5 * self.slices * step
        variance = band_variance(
            frequency - 0.5 * step,
            np.minimum(frequency + 0.5 * step, edge),
            sigma=self.sigma,
            mean_speed=self.speed,
            hub_height=self.hub,
        )
        if self.scaling == "expectation":
            variance *= self._targets() / variance.sum(axis=0)
        return variance

    def _correlated(self, noise: GridNoise, frequency: FloatArray, white: FloatArray) -> FloatArray:
        """White noise (K, points, 6), two numbers a component, correlated at each frequency."""
        nearest = self._coherence(frequency, np.array([noise.nearest]))
        few = int(np.count_nonzero(nearest > RESOLUTION))  # it falls with the frequency
        if few:
            part = slice(None) if self.coupled == "uvw" else slice(None, None, 3)
            white[:few, :, part] = noise.correlate(
                lambda distance: self._coherence(frequency[:few], distance),
                np.ascontiguousarray(white[:few, :, part]),
            )
        return white

    def _coherence(self, frequency: FloatArray, distance: FloatArray) -> FloatArray:
        return coherence(frequency[:, None], distance, mean_speed=self.speed, hub_height=self.hub)
