"""The price of RMS at which a design for a given loss of torque is best over all profiles.

The multiplier of the loss constraint at a local optimum says what the next newton metre of torque
would buy there.  Objective and bound of the trade-off at that price mean something only where
no profile elsewhere is worth more at it.  With other profiles of mean torque T' and weighted RMS
J' known, the design (T, J) is worth no less than any of them, T - mu J >= T' - mu J', for

    max over T' > T of (T' - T) / (J' - J)  <=  mu  <=  min over T' < T of (T - T') / (J - J').

Every mu in that interval is a multiplier of the constraint in the global sense (Boyd and
Vandenberghe, section 5.6).  Where it is empty, the design lies above a chord between two other
profiles: no price makes it best, and the price at which it falls behind least,

    min over mu of max over the others of (T' - T) - mu (J' - J),

leaves the gap that the problem itself has.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

__all__ = ["supporting_price"]

FloatArray = NDArray[np.float64]

_SAME = 1e-6  # share by which profiles must differ in both: slopes between equals mean nothing


def supporting_price(torque: float, rms: float, others: FloatArray, local: float) -> float:
    """Price at which a design is best among known profiles, near the local multiplier.

    Parameters
    ----------
    torque, rms : float
        Mean torque and weighted RMS of the design [N m].
    others : array (P, 2)
        The same of other feasible profiles.
    local : float
        Inverse of the constraint's multiplier at the design [-].

    Returns
    -------
    float
        ``local`` if it lies in the interval, else the minimiser of what the design falls behind
        the others by, or is ahead of them by least.
    """
    gained, varied = others[:, 0] - torque, others[:, 1] - rms
    apart = (np.abs(gained) > _SAME * abs(torque)) & (np.abs(varied) > _SAME * rms)
    costly = apart & (gained > 0) & (varied > 0)
    cheap = apart & (gained < 0) & (varied < 0)
    low = float(np.max(gained[costly] / varied[costly], initial=0.0))
    high = float(np.min(gained[cheap] / varied[cheap], initial=np.inf))
    if low <= local <= high:
        return local
    if low == 0.0 or np.isinf(high):
        return high if low == 0.0 else low
    gained, varied = gained[costly | cheap], varied[costly | cheap]
    behind = minimize_scalar(
        lambda mu: float(np.max(gained - mu * varied)),
        bounds=(min(low, high), max(low, high)),
        method="bounded",
        options={"xatol": 1e-6 * min(low, high)},
    )
    return float(behind.x)
