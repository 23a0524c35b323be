"""Blade-element momentum balance of every section, solved for its inflow angle.

With V_n, V_t the wind relative to the section, a and a' the induction factors and sigma the
local solidity B c / (2 pi r), the balance is one equation in phi,

    sin phi / (1 - a) - V_n / V_t  cos phi (1 - kappa') = 0,
    kappa  = sigma C_n / (4 F sin^2 phi),        kappa' = sigma C_t / (4 F sin phi cos phi),
    a = kappa / (1 + kappa)                       momentum theory, kappa <= 2/3
    a from Buhl's parabola in kappa and F         above (a > 0.4)
    a = kappa / (kappa - 1)                       propeller brake (phi and V_n of unlike sign)
    a' = kappa' / (1 - kappa'),

which always has a bracketed root (S. A. Ning, Wind Energy 17, 2014, 1327-1345; M. L. Buhl,
NREL/TP-500-36834, 2005).  F is Prandtl's loss factor of tip and hub.  All sections, azimuths
and pitches are solved together by Chandrupatla's method (bisection and inverse quadratic
interpolation), which never leaves the bracket.

In a skewed wake the axial induction is redistributed after the balance (Glauert; Pitt and
Peters), a (1 + 15 pi / 32 tan(chi / 2) r / R sin psi_s) with chi = (1 + 0.6 a) chi_0; psi_s is a
quarter turn where the blade points farthest downwind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.polars import Polar
from pitchopt.checks import FloatArray

__all__ = [
    "Induction",
    "Momentum",
    "SectionPolars",
    "axial_induction",
    "loss_factor",
    "skew_redistribution",
    "solve_bracketed",
    "solve_induction",
]

_EDGE = 1e-6  # [rad] from the singular angles 0 and pi/2
_STILL = 1e-3  # [m/s] slower relative wind has no induction
_MIN_LOSS = 1e-4
_SKEW = 15.0 * np.pi / 32.0


@dataclass(frozen=True, kw_only=True)
class Momentum:
    """Options of the balance.

    Parameters
    ----------
    tangential : bool
        Solve for the tangential induction too.
    axial_drag, tangential_drag : bool
        Whether drag counts in the axial and in the tangential balance.
    tip_loss, hub_loss : bool
        Prandtl's factors.
    """

    tangential: bool = True
    axial_drag: bool = False
    tangential_drag: bool = False
    tip_loss: bool = True
    hub_loss: bool = True


class Induction(NamedTuple):
    """Induction factors and inflow angle of the balance, (..., E).

    `solved` is False where there was nothing to solve (no wind) or no bracket; the factors are
    zero there.
    """

    axial: FloatArray
    tangential: FloatArray
    phi: FloatArray
    solved: NDArray[np.bool_]


class SectionPolars:
    """Polars of the stations along a blade, looked up together.

    Parameters
    ----------
    polars : sequence of Polar, length E
    """

    def __init__(self, polars: tuple[Polar, ...]) -> None:
        seen: dict[int, int] = {}
        self.unique: list[Polar] = []
        self.group = np.empty(len(polars), dtype=np.intp)
        for e, polar in enumerate(polars):
            if id(polar) not in seen:
                seen[id(polar)] = len(self.unique)
                self.unique.append(polar)
            self.group[e] = seen[id(polar)]

    def coefficients(self, alpha: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cl, Cd, Cm for angles of attack (..., E)."""
        cl, cd, cm = (np.empty_like(alpha) for _ in range(3))
        for g, polar in enumerate(self.unique):
            where = np.flatnonzero(self.group == g)
            cl[..., where], cd[..., where], cm[..., where] = polar.coefficients(alpha[..., where])
        return cl, cd, cm


def loss_factor(sin_phi: FloatArray, tip: FloatArray, hub: FloatArray) -> FloatArray:
    """Prandtl's F for tip and hub constants B (R - r) / (2 r) and B (r - R_h) / (2 R_h)."""
    s = np.abs(sin_phi)
    outer = np.arccos(np.exp(-tip / s))
    inner = np.arccos(np.exp(-hub / s))
    return np.asarray(np.maximum((2.0 / np.pi) ** 2 * outer * inner, _MIN_LOSS))


def axial_induction(kappa: FloatArray, loss: FloatArray) -> FloatArray:
    """a of the momentum and empirical (Buhl) regions for kappa > -1."""
    two = 2.0 * loss * kappa
    g1 = two - (10.0 / 9.0 - loss)
    g2 = np.abs(two - loss * (4.0 / 3.0 - loss))
    g3 = two - (25.0 / 9.0 - 2.0 * loss)
    near = np.abs(g3) < 1e-6
    root = np.sqrt(g2)
    with np.errstate(divide="ignore", invalid="ignore"):
        buhl = np.where(near, 1.0 - 0.5 / root, (g1 - root) / np.where(near, 1.0, g3))
        momentum = kappa / (1.0 + kappa)
    return np.asarray(np.where(kappa <= 2.0 / 3.0, momentum, buhl))


def skew_redistribution(
    axial: FloatArray, skew_angle: FloatArray, share: FloatArray, sin_psi: FloatArray
) -> FloatArray:
    """Axial induction in a skewed wake.

    Parameters
    ----------
    axial : ndarray
        Induction of the balance.
    skew_angle : ndarray
        Angle chi_0 between the wind and the shaft [rad].
    share : ndarray
        r / R.
    sin_psi : ndarray
        Component of e_r along the wind's direction within the rotor plane.
    """
    chi = (1.0 + 0.6 * axial) * skew_angle
    factor = np.tan(np.clip(chi, -np.pi / 2, np.pi / 2) / 2)
    return np.asarray(axial * (1.0 + _SKEW * factor * share * sin_psi))


def solve_bracketed(
    function: Callable[[FloatArray, NDArray[np.intp]], FloatArray],
    low: FloatArray,
    high: FloatArray,
    at_low: FloatArray,
    at_high: FloatArray,
    *,
    tolerance: float = 1e-13,
    iterations: int = 100,
) -> FloatArray:
    """Roots of many functions of one variable, each within its bracket.

    Chandrupatla's hybrid of bisection and inverse quadratic interpolation (Advances in
    Engineering Software 28, 1997, 145-149); every iterate stays in the bracket.

    Parameters
    ----------
    function : callable
        ``function(x, index)`` evaluates the functions numbered `index` at `x`.
    low, high, at_low, at_high : ndarray (n,)
        Brackets and values there, of unlike sign.
    tolerance : float
        Half width of the bracket at which a root counts as found.

    Returns
    -------
    ndarray (n,)
    """
    index = np.arange(low.size)
    root = np.where(np.abs(at_low) < np.abs(at_high), low, high)
    a, b, fa, fb = high.copy(), low.copy(), at_high.copy(), at_low.copy()
    c, fc = a.copy(), fa.copy()
    share = np.full(low.size, 0.5)
    for _ in range(iterations):
        x = a + share * (b - a)
        fx = function(x, index)
        same = np.sign(fx) == np.sign(fa)
        c = np.where(same, a, b)
        fc = np.where(same, fa, fb)
        b = np.where(same, b, a)
        fb = np.where(same, fb, fa)
        a, fa = x, fx
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        width = np.abs(b - a)
        limit = tolerance + 4e-16 * np.abs(best)
        with np.errstate(divide="ignore", invalid="ignore"):
            minimum = limit / width
        done = (minimum > 0.5) | (fa == 0.0) | (fb == 0.0) | (width == 0.0)
        if np.any(done):
            root[index[done]] = best[done]
            keep = ~done
            if not np.any(keep):
                return root
            index, minimum = index[keep], minimum[keep]
            a, b, c, fa, fb, fc = (v[keep] for v in (a, b, c, fa, fb, fc))
        with np.errstate(divide="ignore", invalid="ignore"):
            xi = (a - b) / (c - b)
            eta = (fa - fb) / (fc - fb)
            smooth = (1.0 - np.sqrt(1.0 - xi) < eta) & (eta < np.sqrt(xi))
            quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (
                fc - fa
            ) * fb / (fc - fb)
        share = np.where(smooth & np.isfinite(quadratic), quadratic, 0.5)
        share = np.clip(share, minimum, 1.0 - minimum)
    root[index] = np.where(np.abs(fa) < np.abs(fb), a, b)
    return root


class _Balance:
    """The residual on flattened sections, sorted by polar so that lookups are contiguous."""

    def __init__(
        self,
        polars: SectionPolars,
        normal: FloatArray,
        tangential: FloatArray,
        theta: FloatArray,
        solidity: FloatArray,
        tip: FloatArray,
        hub: FloatArray,
        options: Momentum,
    ) -> None:
        self.options = options
        self.polars = polars
        self.normal, self.ratio, self.theta = normal, normal / tangential, theta
        self.solidity, self.tip, self.hub = solidity, tip, hub
        self.starts = np.zeros(0, dtype=np.intp)

    def sort(self, group: NDArray[np.intp]) -> None:
        self.starts = np.searchsorted(group, np.arange(len(self.polars.unique) + 1))

    def terms(
        self, phi: FloatArray, index: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """kappa, kappa', F at inflow angles of the sections `index` (sorted)."""
        s, c = np.sin(phi), np.cos(phi)
        alpha = phi - self.theta[index]
        cuts = np.searchsorted(index, self.starts)
        cl = np.empty_like(phi)
        drag = self.options.axial_drag or self.options.tangential_drag
        cd = np.zeros_like(phi)
        for g, polar in enumerate(self.polars.unique):
            part = slice(cuts[g], cuts[g + 1])
            cl[part] = np.interp(alpha[part], polar.alpha, polar.cl)
            if drag:
                cd[part] = np.interp(alpha[part], polar.alpha, polar.cd)
        cn = cl * c + (cd * s if self.options.axial_drag else 0.0)
        loss = loss_factor(s, self.tip[index], self.hub[index])
        common = self.solidity[index] / (4.0 * loss * s)
        kappa = common * cn / s
        if not self.options.tangential:
            return kappa, np.zeros_like(phi), loss
        ct = cl * s - (cd * c if self.options.tangential_drag else 0.0)
        sign = np.where(self.normal[index] < 0.0, -1.0, 1.0)
        return kappa, sign * common * ct / c, loss

    def residual(self, phi: FloatArray, index: NDArray[np.intp]) -> FloatArray:
        kappa, kappa_t, loss = self.terms(phi, index)
        momentum = (phi > 0.0) == (self.normal[index] >= 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = np.where(
                kappa <= 2.0 / 3.0, 1.0 + kappa, 1.0 / (1.0 - axial_induction(kappa, loss))
            )
        first = np.sin(phi) * np.where(momentum, inverse, 1.0 - kappa)
        return np.asarray(first - self.ratio[index] * np.cos(phi) * (1.0 - kappa_t))

    def factors(self, phi: FloatArray, index: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        kappa, kappa_t, loss = self.terms(phi, index)
        momentum = (phi > 0.0) == (self.normal[index] >= 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            axial = np.where(momentum, axial_induction(kappa, loss), kappa / (kappa - 1.0))
            tangential = kappa_t / (1.0 - kappa_t)
        return np.clip(axial, -1.0, 1.5), np.clip(tangential, -1.0, 1.0)


def solve_induction(
    polars: SectionPolars,
    normal: FloatArray,
    tangential: FloatArray,
    theta: FloatArray,
    solidity: FloatArray,
    tip: FloatArray,
    hub: FloatArray,
    options: Momentum | None = None,
) -> Induction:
    """Momentum balance of all sections.

    Parameters
    ----------
    polars : SectionPolars
        Of the E stations.
    normal, tangential : ndarray (..., E)
        Wind relative to the section without induction [m/s].
    theta : ndarray (..., E)
        Twist plus pitch [rad].
    solidity : ndarray (..., E)
        B c / (2 pi r).
    tip, hub : ndarray (E,)
        Constants of the loss factors, B (R - r) / (2 r) and B (r - R_h) / (2 R_h); a station
        with one of them zero is fully blocked: a = 1, a' = 0.
    options : Momentum, optional

    Returns
    -------
    Induction
    """
    choice = options or Momentum()
    shape = np.broadcast_shapes(normal.shape, tangential.shape, theta.shape)
    order = np.argsort(polars.group, kind="stable")

    def flat(array: FloatArray) -> FloatArray:
        full = np.broadcast_to(array, shape)[..., order]
        return np.ascontiguousarray(np.moveaxis(full, -1, 0)).ravel()

    per_station = int(np.prod(shape[:-1]))
    group = np.repeat(polars.group[order], per_station)
    big = np.full(shape[-1], 1e9)
    tip_used = np.asarray(tip if choice.tip_loss else big)
    hub_used = np.asarray(hub if choice.hub_loss else big)
    vn, vt, tips, hubs = flat(normal), flat(tangential), flat(tip_used), flat(hub_used)
    blocked = (tips <= 0.0) | (hubs <= 0.0)
    live = ~blocked & (np.abs(vn) > _STILL) & (np.abs(vt) > _STILL)
    where = np.flatnonzero(live)
    balance = _Balance(
        polars,
        vn[where],
        vt[where],
        flat(theta)[where],
        flat(solidity)[where],
        tips[where],
        hubs[where],
        choice,
    )
    balance.sort(group[where])
    root, found = _roots(balance)
    axial = np.where(blocked, 1.0, 0.0)
    swirl = np.zeros(vn.size)
    phi = np.arctan2(vn * (1.0 - axial), vt)
    solved = np.zeros(vn.size, dtype=bool)
    index = np.flatnonzero(found)
    a, a_t = balance.factors(root[index], index)
    target = where[index]
    axial[target], swirl[target], phi[target], solved[target] = a, a_t, root[index], True

    inverse = np.empty_like(order)
    inverse[order] = np.arange(order.size)

    def back(array: NDArray[np.generic]) -> NDArray[np.generic]:
        return np.moveaxis(array.reshape(shape[-1], *shape[:-1])[inverse], 0, -1)

    return Induction(
        axial=np.asarray(back(axial), dtype=np.float64),
        tangential=np.asarray(back(swirl), dtype=np.float64),
        phi=np.asarray(back(phi), dtype=np.float64),
        solved=np.asarray(back(solved), dtype=bool),
    )


def _chosen_residual(
    balance: _Balance, chosen: NDArray[np.intp], phi: FloatArray, index: NDArray[np.intp]
) -> FloatArray:
    return balance.residual(phi, chosen[index])


def _roots(balance: _Balance) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Root of every section, trying the brackets in Ning's order."""
    count = balance.normal.size
    root = np.zeros(count)
    found = np.zeros(count, dtype=bool)
    sign = np.where(balance.normal < 0.0, -1.0, 1.0)
    half = np.pi / 2
    for low, high in ((_EDGE, half - _EDGE), (-half / 2, -_EDGE), (half + _EDGE, np.pi - _EDGE)):
        index = np.flatnonzero(~found)
        if index.size == 0:
            break
        a, b = sign[index] * low, sign[index] * high
        fa, fb = balance.residual(a, index), balance.residual(b, index)
        ok = np.isfinite(fa) & np.isfinite(fb) & (np.sign(fa) * np.sign(fb) <= 0.0)
        chosen = index[ok]
        if chosen.size == 0:
            continue
        root[chosen] = solve_bracketed(
            partial(_chosen_residual, balance, chosen),
            a[ok],
            b[ok],
            fa[ok],
            fb[ok],
        )
        found[chosen] = True
    return root, found
