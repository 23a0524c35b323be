"""Journal of a study: every candidate and every evaluation in one SQLite file.

What is written is on the disk before the next candidate is asked for (write-ahead log, full
synchronisation), so that a study which is killed at any instant goes on from the file as an
unbroken one would have.  Several processes of one machine may work on one file: each evaluation is
claimed by one of them, and a claim of a process that is gone falls to the others.

    settings    what the study is: another study does not go on in this file
    candidates  number, point, origin, note of the tuner
    claims      who evaluates a candidate
    results     what came of it

Numbers are kept as JSON, which gives back the same floats; NaN is null.
"""

from __future__ import annotations

import csv
import json
import math
import os
import sqlite3
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Candidate, Evaluation

if TYPE_CHECKING:
    from typing import Self

__all__ = ["Journal"]

FORMAT = 1
_APPLICATION = 0x50495443  # "PITC"
_TABLES = """
create table settings (name text primary key, value text not null);
create table candidates (
    number integer primary key, x text not null, origin text not null, note text not null);
create table claims (number integer primary key, process integer not null, born text not null,
    owner text not null);
create table results (
    number integer primary key, status text not null, cost text not null, variance text not null,
    constraints text not null, measures text not null, replicates text not null,
    message text not null, seconds real not null);
"""
_WAIT = 30.0  # for another process that writes [s]


class Journal:
    """A study's file.

    Parameters
    ----------
    path : str or Path
        Made where there is none.
    settings : mapping, optional
        Plain data that names the study.  A file that holds other settings is refused.  Without
        them the file is opened for reading, and must exist.

    Raises
    ------
    InputError
        If the file is of another study or of another format, damaged, no journal, or cannot be
        written.
    """

    def __init__(
        self, path: str | os.PathLike[str], settings: Mapping[str, object] | None = None
    ) -> None:
        self.path = Path(path)
        self._owner = uuid.uuid4().hex
        self._read_only = settings is None
        with self._errors():
            self._database = self._open()
            try:
                self._check_kind(new=settings is not None)
                if settings is not None:
                    self._check_settings(json.loads(_text(settings)))
            except BaseException:
                self._database.close()
                raise

    def _open(self) -> sqlite3.Connection:
        if self._read_only and not self.path.is_file():
            raise InputError(f"journal: there is no file {self.path}")
        if not self.path.parent.is_dir():
            raise InputError(f"journal: got {self.path}, and there is no folder {self.path.parent}")
        if self._read_only:
            return self._open_for_reading()
        if self.path.exists() and not self.path.stat().st_mode & 0o222:
            raise InputError(f"journal: {self.path} is read-only; choose another file")
        database = self._connect("")
        database.execute("pragma journal_mode=wal")
        database.execute("pragma synchronous=full")
        return database

    def _open_for_reading(self) -> sqlite3.Connection:
        database = self._connect("?mode=ro")
        try:
            database.execute("select 1 from sqlite_master")
        except sqlite3.OperationalError:  # the log cannot be opened in a folder that is read-only
            database.close()
            database = self._connect("?immutable=1")
        return database

    def _connect(self, how: str) -> sqlite3.Connection:
        return sqlite3.connect(
            self.path.resolve().as_uri() + how, uri=True, timeout=_WAIT, isolation_level=None
        )

    def _check_kind(self, *, new: bool) -> None:
        """See that the file is a journal of this format, and make it one if it is empty."""
        with self._writing() if new else nullcontext():
            tables = self._all("select name from sqlite_master")
            if new and not tables:
                self._database.execute(f"pragma application_id={_APPLICATION}")
                self._database.execute(f"pragma user_version={FORMAT}")
                for statement in _TABLES.split(";"):
                    self._database.execute(statement)
                return
            if self._all("pragma application_id") != [(_APPLICATION,)]:
                raise InputError(
                    f"journal: {self.path} is no journal of a study; choose another file"
                )
            (version,) = self._all("pragma user_version")[0]
            if version != FORMAT:
                raise InputError(
                    f"journal: {self.path} has format {version}, expected {FORMAT}: another "
                    "version of pitchopt wrote it; choose another file"
                )
            (state,) = self._all("pragma quick_check(1)")[0]
            if state != "ok":
                raise InputError(f"journal: {self.path} is damaged: {state}")

    def _check_settings(self, settings: dict[str, Any]) -> None:
        with self._writing():
            known = self.settings
            if not known:
                self._database.executemany(
                    "insert into settings values (?, ?)",
                    [(name, _text(value)) for name, value in settings.items()],
                )
                return
        differing = sorted(
            f"{path} is {old}, here {new}" for path, old, new in _differences(known, settings)
        )
        if differing:
            more = f" and {len(differing) - 3} more" if len(differing) > 3 else ""
            raise InputError(
                f"journal: {self.path} is of another study: {'; '.join(differing[:3])}{more}; "
                "go on with the same settings or choose another file"
            )

    @property
    def settings(self) -> dict[str, Any]:
        """What the study is."""
        rows = self._all("select name, value from settings order by rowid")
        return {name: json.loads(value) for name, value in rows}

    def candidates(self) -> list[Candidate]:
        """All that was asked for, in that order."""
        rows = self._all("select number, x, origin, note from candidates order by number")
        return [
            Candidate(index=number, x=np.array(json.loads(x)), origin=origin, note=json.loads(note))
            for number, x, origin, note in rows
        ]

    def candidate(self, number: int) -> Candidate | None:
        """One of them, if it is there."""
        rows = self._all("select x, origin, note from candidates where number=?", number)
        if not rows:
            return None
        x, origin, note = rows[0]
        return Candidate(
            index=number, x=np.array(json.loads(x)), origin=origin, note=json.loads(note)
        )

    def evaluations(self) -> list[Evaluation]:
        """All results in the order of candidates."""
        rows = self._all(
            "select number, x, origin, note, status, cost, variance, constraints, measures, "
            "replicates, message, seconds from results join candidates using (number) "
            "order by number"
        )
        return [_evaluation(*row) for row in rows]

    def result(self, number: int) -> Evaluation | None:
        """Result of one candidate, if it is there."""
        rows = self._all(
            "select number, x, origin, note, status, cost, variance, constraints, measures, "
            "replicates, message, seconds from results join candidates using (number) "
            "where number=?",
            number,
        )
        return _evaluation(*rows[0]) if rows else None

    def ask(self, candidate: Candidate) -> None:
        """Write a candidate down.

        Raises
        ------
        InputError
            If another process asked for another point under this number.
        """
        with self._writing():
            known = self.candidate(candidate.index)
            if known is None:
                self._database.execute(
                    "insert into candidates values (?, ?, ?, ?)",
                    (
                        candidate.index,
                        _text(candidate.x.tolist()),
                        candidate.origin,
                        _text(dict(candidate.note)),
                    ),
                )
            elif not np.array_equal(known.x, candidate.x):
                raise InputError(
                    f"journal: {self.path} has {np.array2string(known.x)} as candidate "
                    f"{candidate.index}, and the study asks for {np.array2string(candidate.x)}"
                )

    def claim(self, number: int) -> bool:
        """Whether this process is to evaluate a candidate: no other that lives does, or did."""
        me = os.getpid()
        with self._writing():
            if self._all("select 1 from results where number=?", number):
                return False
            rows = self._all("select process, born, owner from claims where number=?", number)
            if rows and rows[0][2] != self._owner and _alive(rows[0][0], rows[0][1]):
                return False
            self._database.execute(
                "insert or replace into claims values (?, ?, ?, ?)",
                (number, me, _born(me), self._owner),
            )
        return True

    def tell(self, evaluation: Evaluation) -> None:
        """Write a result down, once."""
        with self._writing():
            self._database.execute(
                "insert or ignore into results values (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                (
                    evaluation.index,
                    evaluation.status,
                    _text(evaluation.cost),
                    _text(evaluation.variance),
                    _text(list(evaluation.constraints)),
                    _text(dict(evaluation.measures)),
                    _text(list(evaluation.replicates)),
                    evaluation.message,
                    evaluation.seconds,
                ),
            )

    def release(self) -> None:
        """Give up this journal's own claims without results."""
        with self._writing():
            self._database.execute("delete from claims where owner=?", (self._owner,))

    def table(self) -> tuple[list[str], list[list[object]]]:
        """Names of columns, and a row for each evaluation: number, origin, point, results."""
        evaluations = self.evaluations()
        parameters = [p["name"] for p in self.settings["space"]["parameters"]]
        measures = list(dict.fromkeys(name for e in evaluations for name in e.measures))
        width = max((len(e.constraints) for e in evaluations), default=0)
        names = [
            *("number", "origin", *parameters, "status", "cost", "variance"),
            *(f"constraint_{k + 1}" for k in range(width)),
            *measures,
            *("seconds", "message"),
        ]
        rows: list[list[object]] = [
            [
                *(e.index, e.origin, *e.x.tolist(), e.status, e.cost, e.variance),
                *(e.constraints[k] if k < len(e.constraints) else None for k in range(width)),
                *(e.measures.get(name) for name in measures),
                *(e.seconds, e.message),
            ]
            for e in evaluations
        ]
        return names, rows

    def write_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV; what is not there is an empty field."""
        names, rows = self.table()
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows(["" if _missing(v) else v for v in row] for row in rows)

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _all(self, query: str, *values: object) -> list[tuple[Any, ...]]:
        with self._errors():
            return self._database.execute(query, values).fetchall()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """One transaction, whole or not at all."""
        with self._errors():
            try:
                self._database.execute("begin immediate")
                yield
                self._database.execute("commit")
            except BaseException:
                if self._database.in_transaction:  # a full disk may have ended it
                    self._database.execute("rollback")
                raise

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.OperationalError as error:
            text = str(error)
            if "readonly" in text or "unable to open" in text:
                raise InputError(f"journal: {self.path} cannot be opened or written") from error
            raise InputError(f"journal: {self.path}: {text}") from error
        except (sqlite3.DatabaseError, json.JSONDecodeError) as error:
            raise InputError(
                f"journal: {self.path} is no journal of a study, or is damaged ({error})"
            ) from error


def _text(value: object) -> str:
    """JSON of plain data; NaN and infinity, which JSON has not, as null and as text."""
    return json.dumps(_plain(value), allow_nan=False)


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def _number(value: object) -> float:
    return math.nan if value is None else float(value)  # type: ignore[arg-type]


def _evaluation(
    number: int, x: str, origin: str, note: str, status: Any, cost: str, variance: str,
    constraints: str, measures: str, replicates: str, message: str, seconds: float,
) -> Evaluation:  # fmt: skip
    spread = json.loads(variance)
    return Evaluation(
        index=number,
        x=np.array(json.loads(x)),
        origin=origin,
        note=json.loads(note),
        status=status,
        cost=_number(json.loads(cost)),
        variance=None if spread is None else float(spread),
        constraints=tuple(_number(c) for c in json.loads(constraints)),
        measures={name: _number(value) for name, value in json.loads(measures).items()},
        replicates=tuple(_number(r) for r in json.loads(replicates)),
        message=message,
        seconds=seconds,
    )


def _differences(old: object, new: object, path: str = "") -> Iterator[tuple[str, str, str]]:
    """Places where plain data differ, as a path and both values in short."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in dict.fromkeys([*old, *new]):
            yield from _differences(
                old.get(name), new.get(name), f"{path}.{name}" if path else str(name)
            )
    elif old != new:
        yield path, _short(old), _short(new)


def _short(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _missing(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def _born(process: int) -> str:
    """When a process began, as the system counts; empty where that cannot be read."""
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
    return stat.rpartition(")")[2].split()[19]


def _alive(process: int, born: str) -> bool:
    """Whether a process lives and is the one that was meant.

    Windows cannot be asked this way: a study there has one process at a time.
    """
    if os.name == "nt":
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return _born(process) == born
