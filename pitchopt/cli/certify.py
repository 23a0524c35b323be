"""From the options about proofs to their settings, with the processes that work on them."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.design import ProofSettings

__all__ = ["certify_record", "proof_settings"]


@contextmanager
def proof_settings(options: Mapping[str, Any]) -> Iterator[bool | ProofSettings]:
    """What ``certify`` of the design functions is to be.

    The processes of a deep proof start when the first work comes and end with the context.  They
    leave an interrupt from the keyboard to the command, which keeps what is proven by then.
    """
    _checked(options)
    if options["no_certify"] or options["certify"] != "deep":
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
    record: dict[str, Any] = {"certify": "none" if options["no_certify"] else options["certify"]}
    if record["certify"] == "deep":
        record["certify_gap"] = options["certify_gap"]
        record["certify_seconds"] = options["certify_seconds"]
    return record


def _checked(options: Mapping[str, Any]) -> None:
    if options["no_certify"] and options["certify"] == "deep":
        raise InputError(
            "--no-certify: got it together with --certify deep, expected one of the two"
        )
    if options.get("resume") and options["certify"] != "deep":
        raise InputError("--resume: got a file without --certify deep, expected both or neither")
