"""From the options about proofs to their settings, with the processes that work on them."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.checks import FloatArray
    from pitchopt.design import Design, ProofSettings

__all__ = ["better_intervals", "certify_record", "proof_settings"]


@contextmanager
def proof_settings(options: Mapping[str, Any]) -> Iterator[bool | ProofSettings]:
    """What ``certify`` of the design functions is to be.

    The processes of a deep proof start when the first work comes and end with the context.  They
    leave an interrupt from the keyboard to the command, which keeps what is proven by then.
    """
    _checked(options)
    if not _deep(options):
        yield not options["no_certify"]
        return
    from pitchopt.design import ProofSettings

    workers = options["workers"] or os.cpu_count() or 1
    gap, seconds = options["certify_gap"], options["certify_seconds"]
    if workers == 1:
        yield ProofSettings(gap=gap, seconds=seconds)
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    pool = ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),
    )
    try:
        yield ProofSettings(gap=gap, seconds=seconds, executor=pool, workers=workers)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def certify_record(options: Mapping[str, Any]) -> dict[str, Any]:
    """The same for the record of settings."""
    if not _deep(options):
        return {"certify": "none" if options["no_certify"] else "fast"}
    return {
        "certify": "deep",
        "certify_gap": options["certify_gap"],
        "certify_seconds": options["certify_seconds"],
    }


def _deep(options: Mapping[str, Any]) -> bool:
    """True for branch and bound; commands without the option have none."""
    return options.get("certify") == "deep" and not options["no_certify"]


def better_intervals(design: Design) -> tuple[FloatArray, FloatArray] | None:
    """Where profiles better than a design would have to lie; None without a branch and bound."""
    certificate = design.certificate
    if certificate is None or certificate.proof is None:
        return None
    return certificate.intervals(design.objective)


def _checked(options: Mapping[str, Any]) -> None:
    if options["no_certify"] and options.get("certify") == "deep":
        raise InputError(
            "--no-certify: got it together with --certify deep, expected one of the two"
        )
    if options.get("resume") and options.get("certify") != "deep":
        raise InputError("--resume: got a file without --certify deep, expected both or neither")
