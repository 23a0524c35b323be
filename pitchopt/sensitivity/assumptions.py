"""What an estimate rests on, judged: active set, coupling, linearity, stationarity.

A3, the active set: rows that were inactive and become active or violated when they are
re-evaluated at (x*, c_r + dc), or that the predicted step dx reaches; rows that were active and
that dx leaves or cannot hold.  Rows that do not depend on c are only ever reached.  Where the
active rows determine dx, at a vertex, rows that it repairs again do not count.
A2, no coupling: norm of D (grad_x L(x*, c_r + dc) - grad_x L(x*, c_r)) over that of D grad_x f.
At an exact optimum the second gradient is zero; subtracting it leaves out what the solver left.
A1, linearity: |L(x* + dx, c_r) - L(x*, c_r)| over the size of the estimate.  The entries of a cone
may be linear in x and the cone still bends: its excess at (x* + dx, c_r + dc) times its multiplier,
less what L has of it already, is added.
"""

from __future__ import annotations

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sensitivity.estimate import Assumption, Thresholds, rows_text
from pitchopt.sensitivity.local import Local, Rows
from pitchopt.sensitivity.model import Gradients, Model, Values

__all__ = ["active_set", "coupling", "linearity", "not_judged", "stationarity"]

A1, A2, A3, KKT = "A1 linearity", "A2 coupling", "A3 active set", "stationarity"
NEGLIGIBLE = 1e-9
SEEN = 10.0


def not_judged(name: str, reason: str, threshold: float) -> Assumption:
    """An assumption that nothing is known of."""
    return Assumption(
        name=name, verdict="not judged", measure=None, threshold=threshold, message=reason
    )


def stationarity(local: Local, thresholds: Thresholds) -> Assumption:
    """Whether the multipliers belong to the optimum."""
    measure, limit = local.stationarity, thresholds.stationarity
    holds = measure <= limit
    message = f"grad_x L at the optimum is {measure:.2g} of the size of grad_x f"
    if local.gradients.error > 0.0:
        message += (
            f" (gradients by differences, with a relative error of {local.gradients.error:.1g})"
        )
    if not holds:
        message += (
            f", above {limit:.2g}: the multipliers do not belong to this optimum, or the functions "
            "have a kink there"
        )
    return Assumption(
        name=KKT, verdict="holds" if holds else "broken", measure=measure, threshold=limit,
        message=message,
    )  # fmt: skip


def coupling(local: Local, there: Gradients | None, thresholds: Thresholds) -> Assumption:
    """A2."""
    limit = thresholds.coupling
    if there is None:
        return not_judged(A2, "there are no gradients in x at the new parameter", limit)
    measure = local.coupling(there)
    holds = measure <= limit
    relation = "at most" if holds else "above"
    return Assumption(
        name=A2, verdict="holds" if holds else "broken", measure=measure, threshold=limit,
        message=f"dc changes grad_x L by {measure:.2g} of the size of grad_x f, {relation} "
        f"{limit:.2g}",
    )  # fmt: skip


def linearity(
    model: Model, local: Local, start: Values, step: FloatArray, moved: Values | None,
    estimate: float, thresholds: Thresholds,
) -> Assumption:  # fmt: skip
    """A1; `moved` is at (x* + dx, c_r + dc), None outside the domain."""
    limit = thresholds.linearity
    try:
        there = model.values(model.reference, step)
    except InputError:
        return not_judged(A1, "the predicted step leaves the domain of the functions", limit)
    off = there.objective - start.objective
    off = abs(off + float(model.multipliers @ (there.entries - start.entries)))
    if moved is not None:
        bent = model.layout.bent(model.multipliers, moved.entries)
        off += max(bent - model.layout.bent(model.multipliers, start.entries), 0.0)
    if off <= NEGLIGIBLE * local.size:
        measure = 0.0
    else:
        measure = off / abs(estimate) if estimate != 0.0 else np.inf
    holds = measure <= limit
    relation = "at most" if holds else "above"
    return Assumption(
        name=A1, verdict="holds" if holds else "broken", measure=measure, threshold=limit,
        message=f"the predicted step changes L by {measure:.2g} of the estimate, {relation} "
        f"{limit:.2g}",
    )  # fmt: skip


def active_set(
    model: Model,
    rows: Rows,
    there: Values,
    thresholds: Thresholds,
    *,
    local: Local | None = None,
    step: FloatArray | None = None,
    left_over: FloatArray | None = None,
) -> Assumption:
    """A3; without gradients re-evaluation alone, which can only break it."""
    layout, tolerance = model.layout, thresholds.active
    excess = layout.excess(there.entries) / rows.length
    violated = rows.inactive & (excess > tolerance)
    becoming = rows.inactive & ~violated & (excess >= -tolerance)
    tightened = rows.idle & (excess > tolerance)
    nothing = np.zeros(layout.rows, dtype=bool)
    reached, left, unheld = nothing, nothing.copy(), nothing.copy()
    largest = 0.0
    if local is not None and step is not None and left_over is not None:
        predicted = there.entries + local.gradients.entries @ step
        after = layout.excess(predicted) / rows.length
        if local.determined:  # a vertex: nothing but the predicted step can follow
            repaired = (violated | becoming | tightened) & (after < -tolerance)
            violated, becoming, tightened = (
                mask & ~repaired for mask in (violated, becoming, tightened)
            )
        reached = (rows.inactive & (after >= -tolerance)) | (rows.idle & (after > tolerance))
        reached &= ~(violated | becoming | tightened)
        slack = np.maximum(tolerance, SEEN * rows.distance)
        left = rows.idle & ~tightened & (after < -slack)
        left |= rows.carrying & (left_over < -tolerance)
        unheld = rows.carrying & (left_over > tolerance)
        gone = reached | violated
        largest = float(np.max(after[gone], initial=0.0))
    found = [
        (violated, "violated at the old design"),
        (becoming, "becoming active"),
        (tightened, "active without a multiplier and tightened"),
        (reached, "reached by the predicted step"),
        (left, "left"),
        (unheld, "not to be held together"),
    ]
    texts = [
        f"{'constraint' if mask.sum() == 1 else f'{mask.sum()} constraints'} {text}: "
        f"{rows_text(layout, np.flatnonzero(mask))}"
        for mask, text in found
        if mask.any()
    ]
    count = int(sum(mask.sum() for mask, _ in found))
    if largest > 0.0:
        texts.append(f"by up to {largest:.2g} of the size of x")
    if count:
        return Assumption(
            name=A3, verdict="broken", measure=float(count), threshold=0.0,
            message="; ".join(texts),
        )  # fmt: skip
    if local is None:
        return not_judged(
            A3,
            "no constraint changes sides where it is re-evaluated, but without gradients in x "
            "nothing tells which ones the new design reaches",
            0.0,
        )
    idle = rows.idle
    note = (
        f"; active without a multiplier: {rows_text(layout, np.flatnonzero(idle))}"
        if idle.any()
        else ""
    )
    return Assumption(
        name=A3, verdict="holds", measure=0.0, threshold=0.0,
        message=f"{int(rows.carrying.sum())} active constraints stay, none joins them{note}",
    )  # fmt: skip
