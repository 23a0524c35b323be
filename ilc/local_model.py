"""LocalModel: what the loads do near the profile in use, kept current by every passage.

At each tracked position a load is modelled around the pitches beta_0 that it was last seen at,

    y(beta_0 + d) = c + g'd + 1/2 sum_b h_b d_b^2,

a value c, slopes g and curvatures h.  Blades share a load as a sum, so curvature has no mixed
terms; it is small and smooth over azimuth, and one Fourier series per load (mean, cosine, sine)
describes it for all stations.  It comes from the experiment; c and g are then tracked by a Kalman
filter in each position and load:

    after a move d      c <- c + g'd + 1/2 h'd^2,  g <- g + h d,
                        covariance  P <- F P F' + Q(d),   F = [1 d'; 0 I],
    after a sample y    (c, g) += K (y - c),  K = P e_1 / (P_11 + R).

Q(d) is what an unknown part of the curvature does: (1/2 r |d|^2)^2 in c and r^2 |d|^2 in each
slope; r^2 is the variance with which the experiment gave the curvature, and (`RESIDUAL` times its
size)^2 for what the series leaves out.  A curvature that noise alone would show is shrunk.  Without
noise the update is Broyden's, spread over the slopes in proportion to what is not known of them;
with noise it averages.  Where innovations are larger than P and R explain, as after a change of
wind, P is raised until they are explained.

Loads are divided by their RMS over the positions at the start, so that nothing depends on units.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ilc._checks import FloatArray, IntArray, array_of
from ilc.layout import Layout

__all__ = ["LocalModel"]

RESIDUAL = 0.15
_LEAST_NOISE = 1e-8  # variance in units of the starting RMS squared
_LEAST_DRIFT = 1e-10  # the same, of the value between two passages
_UNEXPLAINED = 1.5  # ratio of innovations to their variance above which P is raised
_NOTHING = 1e-30  # loads below this are none
_SLOPE_RISE = 0.3  # largest rise of a slope's deviation, as a share of the mean slope


class LocalModel:
    """Value, slope and curvature of the four loads at every tracked position.

    Parameters
    ----------
    layout : Layout
    """

    _ARRAYS = (
        "scale",
        "noise",
        "value",
        "slope",
        "curvature",
        "unknown",
        "covariance",
        "at",
        "surprise",
    )

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        p, b = layout.tracked, layout.blades
        self.scale = np.ones(4)
        """RMS of the loads at the start, their unit."""
        self.noise = np.ones(4)
        """Variance R of the measurements [scale^2]."""
        self.value = np.zeros((4, p))
        """c [scale]."""
        self.slope = np.zeros((4, p, b))
        """g [scale/rad]."""
        self.curvature = np.zeros((4, p, b))
        """h [scale/rad^2]."""
        self.unknown = np.zeros(4)
        """r, size of what is not known of the curvature [scale/rad^2]."""
        self.covariance = np.zeros((4, p, 1 + b, 1 + b))
        """P of (c, g)."""
        self.at = np.zeros((p, b))
        """beta_0 [rad]."""
        self.surprise = np.zeros(4)
        """Mean square innovation of the last passage over its expectation."""

    # ---- from the experiment ---------------------------------------------------------------

    def identify(self, pitch: FloatArray, loads: FloatArray, repeats: int) -> None:
        """Fit the model to the experiment.

        Parameters
        ----------
        pitch : ndarray (E, P, B)
            [rad]
        loads : ndarray (E, 4, P)
            NaN is left out.
        repeats : int
            The first so many rows have the same profile.
        """
        with np.errstate(invalid="ignore"):
            first = _mean(loads[:repeats], axis=0)
            spread = _mean((loads[:repeats] - first) ** 2, axis=(0, 2)) * repeats / (repeats - 1)
        self.scale = _scales(first)
        self.noise = np.maximum(spread / self.scale**2, _LEAST_NOISE)
        seen = np.isfinite(loads) & np.isfinite(pitch.sum(axis=2))[:, None]
        mask = seen.transpose(1, 2, 0).astype(np.float64)  # (4, P, E)
        moves = np.nan_to_num(pitch - pitch[0]).transpose(1, 0, 2)
        target = np.nan_to_num(loads / self.scale[:, None]).transpose(1, 2, 0) * mask
        linear = np.concatenate([np.ones((*moves.shape[:2], 1)), moves], axis=2)
        linear = linear * mask[..., None]
        inverse = np.linalg.pinv(linear, rcond=1e-6)
        waves = self._waves()
        bent = 0.5 * np.einsum("peb,pbw->pew", moves**2, waves) * mask[..., None]
        rest = np.eye(moves.shape[1]) - linear @ inverse
        freedom = np.maximum(mask.sum(axis=2) - linear.shape[3], 0.0).sum(axis=1)
        self.covariance = inverse @ inverse.swapaxes(2, 3)
        for load in range(4):
            columns = (rest[load] @ bent[load]).reshape(-1, waves.shape[2])
            wanted = np.einsum("pef,pf->pe", rest[load], target[load]).ravel()
            series, _, rank, _ = np.linalg.lstsq(columns, wanted, rcond=1e-6)
            misfit = float(((wanted - columns @ series) ** 2).sum())
            variance = max(misfit / max(freedom[load] - rank, 1.0), self.noise[load])
            spread = variance * np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True)
            chance = float(np.einsum("pbv,vw,pbw->pb", waves, spread, waves).mean())
            size = float(((waves @ series) ** 2).mean())
            series *= max(0.0, 1.0 - chance / size) if size > 0 else 0.0
            self.curvature[load] = waves @ series
            self.unknown[load] = np.sqrt(
                (RESIDUAL**2) * (self.curvature[load] ** 2).mean() + chance
            )
            fit = np.einsum("pie,pe->pi", inverse[load], target[load] - bent[load] @ series)
            self.value[load], self.slope[load] = fit[:, 0], fit[:, 1:]
            self.covariance[load] *= variance
        blank = mask.sum(axis=2) < linear.shape[3]  # too few samples to know the slopes by
        usual = self._slope_size()
        for load, position in zip(*np.nonzero(blank), strict=True):
            prior = np.eye(linear.shape[3]) * usual[load] ** 2
            prior[0, 0] = 1.0
            self.covariance[load, position] += prior
        self.at = np.where(np.isfinite(pitch[0]), pitch[0], 0.0)

    def _waves(self) -> FloatArray:
        """Fourier series of the curvature at every position and blade, (P, B, 3)."""
        psi = self.layout.azimuth[self.layout.index]
        return np.stack([np.ones_like(psi), np.cos(psi), np.sin(psi)], axis=2)

    def _slope_size(self) -> FloatArray:
        """Root mean square slope of each load, (4,)."""
        return np.asarray(np.sqrt((self.slope**2).mean(axis=(1, 2))))

    def doubt(self) -> float:
        """Relative deviation of the slopes, over all loads and positions."""
        deviation = np.trace(self.covariance[..., 1:, 1:], axis1=2, axis2=3).mean(axis=1)
        size = (self.slope**2).sum(axis=2).mean(axis=1)
        known = size > 0
        return float(np.sqrt(np.mean(deviation[known] / size[known])))

    # ---- every passage -----------------------------------------------------------------------

    def update(self, rows: IntArray, pitch: FloatArray, loads: FloatArray) -> None:
        """Take in the loads of a passage.

        Parameters
        ----------
        rows : ndarray (S,)
            Tracked positions.
        pitch : ndarray (S, B)
            Pitches applied there [rad].
        loads : ndarray (4, S)
            NaN is left out.
        """
        move = pitch - self.at[rows]
        self._shift(rows, move)
        self.at[rows] = pitch
        seen = np.isfinite(loads)
        innovation = np.where(
            seen, np.nan_to_num(loads) / self.scale[:, None] - self.value[:, rows], 0.0
        )
        covariance = self.covariance[:, rows]
        expected = covariance[..., 0, 0] + self.noise[:, None]
        count = np.maximum(seen.sum(axis=1), 1)
        self.surprise = (innovation**2 / expected).sum(axis=1) / count
        self._raise(covariance, innovation, expected, seen, float((move**2).sum(axis=1).mean()))
        gain = covariance[..., 0] / (covariance[..., 0, 0] + self.noise[:, None])[..., None]
        gain = np.where(seen[..., None], gain, 0.0)
        self.value[:, rows] += gain[..., 0] * innovation
        self.slope[:, rows] += gain[..., 1:] * innovation[..., None]
        self.covariance[:, rows] = covariance - gain[..., :, None] * covariance[..., None, 0, :]

    def _shift(self, rows: IntArray, move: FloatArray) -> None:
        """Carry the model of some positions over to other pitches."""
        curvature = self.curvature[:, rows]
        self.value[:, rows] += np.einsum("lpb,pb->lp", self.slope[:, rows], move)
        self.value[:, rows] += 0.5 * np.einsum("lpb,pb->lp", curvature, move**2)
        self.slope[:, rows] += curvature * move
        covariance = self.covariance[:, rows]
        covariance[..., 0, :] += np.einsum("pb,lpbj->lpj", move, covariance[..., 1:, :])
        covariance[..., :, 0] += np.einsum("pb,lpjb->lpj", move, covariance[..., :, 1:])
        square = (move**2).sum(axis=1)
        unknown = self.unknown[:, None]
        covariance[..., 0, 0] += (0.5 * unknown * square) ** 2 + _LEAST_DRIFT
        inner = np.arange(1, covariance.shape[-1])
        covariance[..., inner, inner] += (unknown**2 * square)[..., None]
        self.covariance[:, rows] = covariance

    def _raise(
        self,
        covariance: FloatArray,
        innovation: FloatArray,
        expected: FloatArray,
        seen: FloatArray,
        move: float,
    ) -> None:
        """Raise the covariance of loads whose innovations it does not explain, in place.

        Half of the excess goes to the values.  Slopes follow in so far as the moves made them show,
        and as a change of the values comes with one of the slopes: as much as curvature gives for
        a change of pitch with the same effect.
        """
        count = np.maximum(seen.sum(axis=1), 1)
        excess = (innovation**2).sum(axis=1) / count - _UNEXPLAINED * (
            np.where(seen, expected, 0.0).sum(axis=1) / count
        )
        size = self._slope_size()
        most = (_SLOPE_RISE * size) ** 2
        bend = np.sqrt((self.curvature**2).mean(axis=(1, 2)) + self.unknown**2)
        inner = np.arange(1, covariance.shape[-1])
        for load in np.nonzero((excess > 0) & (size > 0))[0]:
            covariance[load, :, 0, 0] += 0.5 * excess[load]
            shown = most[load] * min(1.0, most[load] * move / excess[load])
            slopes = excess[load] * (bend[load] / size[load]) ** 2
            slopes += shown if move == 0.0 else min(excess[load] / move, shown)
            covariance[load][:, inner, inner] += min(slopes, most[load])

    # ---- saving ------------------------------------------------------------------------------

    def arrays(self) -> dict[str, FloatArray]:
        """All that the model holds."""
        return {name: getattr(self, name).copy() for name in self._ARRAYS}

    def set_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from :meth:`arrays`."""
        for name in self._ARRAYS:
            setattr(self, name, array_of(name, arrays[name], getattr(self, name).shape))


def _mean(values: FloatArray, axis: int | tuple[int, ...]) -> FloatArray:
    """Mean of what is finite; 0 where nothing is."""
    good = np.isfinite(values)
    total = np.where(good, values, 0.0).sum(axis=axis)
    return np.asarray(total / np.maximum(good.sum(axis=axis), 1))


def _scales(loads: FloatArray) -> FloatArray:
    """RMS over the positions of loads (4, P); the size of the mean for one that does not vary."""
    rms = loads.std(axis=1)
    size = np.abs(loads).mean(axis=1)
    size = np.where(size > _NOTHING, size, 1.0)
    return np.where(rms > np.maximum(1e-9 * size, _NOTHING), rms, size)
