"""Many studies, one command: each becomes a results folder, all of them one table.

A study is one task, in this process or in those of a Dask cluster: what is read, the sums and the maps stay where the
task runs, and only a line comes back. A study that cannot be measured is a line that says why, and stops no other.
A fleet that is interrupted is a table of what was measured until then.
"""

import csv
import io
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final, Literal

import pyarrow as pa
import pyarrow.parquet as pq

from fullwell.errors import FullwellError, UsageError, system_refusal
from fullwell.figures.results import Results
from fullwell.files import RESULTS, RESULTS_SCHEMA, fullness_named, holds_document
from fullwell.findings import Severity
from fullwell.frames.manifest import MANIFEST_NAME
from fullwell.report.reading import read_results
from fullwell.workflow.cache.opening import cache_beside
from fullwell.workflow.characterize import characterize
from fullwell.workflow.cluster import connected
from fullwell.workflow.options import Options

SCHEMA: Final = "fullwell-fleet/1"
INDEX: Final = "fleet.json"
_MEASURED: Final = ("done", "kept")
State = Literal["done", "kept", "failed", "interrupted"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A study and where its results go.

    Parameters
    ----------
    name
        What the study is called in the fleet.
    study, out
        Its folder or manifest, and the folder of its results.
    options
        Of the measurement.
    resume
        Whether results that are there already are kept.

    """

    name: str
    study: Path
    out: Path
    options: Options
    resume: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """What became of a study.

    Parameters
    ----------
    name, study, out
        As in the job.
    state
        ``done``; ``kept`` from an earlier run; ``failed``; or ``interrupted``, before it was done.
    reason
        Why it was not measured, a sentence; empty otherwise.
    errors, warnings
        Findings of these severities.
    duration_s
        How long it took [s].

    """

    name: str
    study: str
    out: str
    state: State
    reason: str
    errors: int
    warnings: int
    duration_s: float


def characterize_fleet(
    studies: Sequence[Path],
    root: Path,
    *,
    options: Options,
    resume: bool = False,
    told: Callable[[Entry], None] | None = None,
) -> tuple[Entry, ...]:
    """Measure many studies.

    Parameters
    ----------
    studies
        Folders or manifests.
    root
        Where each study's results go, into a folder of its name; beside them ``fleet.json``, what became of each,
        ``fleet.csv`` and ``fleet.parquet``, the rows of all with the study's name in front.
    options
        Of every measurement. With a cluster each study is measured by one process, which must see both the study and
        ``root`` under the same path.
    resume
        Whether studies whose results are there already are left as they are.
    told
        Told of every study when it is done.

    Returns
    -------
    tuple of Entry
        By name.

    Raises
    ------
    UsageError
        There is no study, or ``root`` is no folder, or is one of the studies.
    KeyboardInterrupt
        It was interrupted; the sentence says how far it came. What was measured is there, with its tables.

    """
    if not studies:
        raise UsageError("Name at least one study: a folder or a study.toml.")
    if root.exists() and not root.is_dir():
        raise UsageError(f"{root} is a file; name a folder for the results with -o")
    if any(study.resolve() == root.resolve() for study in studies):
        raise UsageError(f"{root} is one of the studies, and results would lie among its frames; name another with -o")
    root.mkdir(parents=True, exist_ok=True)
    jobs = [
        Job(name=name, study=study.absolute(), out=root / name, options=_own(options, root / name), resume=resume)
        for name, study in named(studies).items()
    ]
    entries: list[Entry] = []
    try:
        for entry in _measured(jobs, options):
            entries.append(entry)
            if told is not None:
                told(entry)
    except KeyboardInterrupt as interrupt:
        seen = {entry.name for entry in entries}
        found = _recorded([*entries, *(_left(job) for job in jobs if job.name not in seen)], root)
        there = sum(entry.state in _MEASURED for entry in found)
        raise KeyboardInterrupt(
            f"Interrupted with {there} of {len(jobs)} studies measured; their results and tables are in {root}. "
            "The same command with --resume measures the others."
        ) from interrupt
    return _recorded(entries, root)


def _recorded(entries: Sequence[Entry], root: Path) -> tuple[Entry, ...]:
    """Write the tables of a fleet and what became of each study; return the latter by name."""
    found = tuple(sorted(entries, key=lambda entry: entry.name))
    document = json.dumps({"schema": SCHEMA, "studies": [asdict(entry) for entry in found]}, indent=1) + "\n"
    with fullness_named(root):
        _write_tables([entry for entry in found if entry.state in _MEASURED], root)
        _write(root / INDEX, document.encode())
    return found


def _left(job: Job) -> Entry:
    """Return what becomes of a study that a fleet did not come to the end of: results of an earlier run are kept."""
    try:
        earlier = _earlier(job)
    except UsageError as error:
        return _entry(job, state="failed", reason=str(error))
    if earlier is not None:
        return _entry(job, state="kept", found=earlier)
    return _entry(job, state="interrupted", reason="the fleet was interrupted before this study was measured")


def _own(options: Options, out: Path) -> Options:
    """Return the options of one study: a process of a cluster has one thread, and finished series lie beside OUT."""
    cache = options.cache
    if cache is not None and not cache.shared:
        cache = replace(cache, folder=cache_beside(out))
    return replace(options, dask=None, cache=cache, workers=options.workers if options.dask is None else 1)


def named(studies: Iterable[Path]) -> dict[str, Path]:
    """Return studies by names that tell them apart: that of the folder, with those above it where need be.

    Examples
    --------
    >>> sorted(named([Path("/lab/a/raw"), Path("/lab/b/raw"), Path("/lab/c")]))
    ['a-raw', 'b-raw', 'c']

    """
    whole = {Path(os.path.abspath(study)): study for study in studies}  # noqa: PTH100 - links are kept as they are named
    parts = {
        path: (
            path.parent if path.name == MANIFEST_NAME else path.with_suffix("") if path.suffix == ".toml" else path
        ).parts
        for path in whole
    }
    names: dict[Path, str] = {}
    for depth in range(1, max((len(one) for one in parts.values()), default=0) + 1):
        ends = {path: "-".join(one[-depth:]) for path, one in parts.items() if path not in names}
        counts = Counter(ends.values())
        names |= {path: end for path, end in ends.items() if counts[end] == 1 and end not in names.values()}
    for path in whole:
        if path not in names:
            raise UsageError(f"{path} cannot be told from another study by its name; name the studies by their folders")
    return {names[path]: study for path, study in whole.items()}


def measure_one(job: Job) -> Entry:
    """Measure a study of a fleet; runs where its frames are to be read."""
    started = time.monotonic()
    try:
        earlier = _earlier(job)
        if job.resume and earlier is not None:
            return _entry(job, state="kept", found=earlier)
        results = characterize(job.study, job.out, options=job.options)
    except Exception as error:  # noqa: BLE001 - a defect met by one study must not cost the others
        return _entry(job, state="failed", reason=_reason(error), duration_s=_since(started))
    return _entry(job, state="done", found=results, duration_s=_since(started))


def _reason(error: Exception) -> str:
    """Return in a sentence why a study was not measured."""
    refusal = system_refusal(error) if isinstance(error, OSError) else None
    if refusal is None and not isinstance(error, FullwellError):
        return f"a bug of ours: {type(error).__name__}: {error}; measure this study alone with --verbose, and report it"
    return refusal or str(error)


def _earlier(job: Job) -> Results | None:
    """Return the results that a study has already; None where there are none.

    Names tell the studies of one fleet apart, not those of two: another folder of the same name may have been measured
    into the same place before.

    Raises
    ------
    UsageError
        They are another study's.

    """
    if not holds_document(job.out, RESULTS, schema=RESULTS_SCHEMA):
        return None
    found = read_results(job.out)
    whose = found.run.get("study")
    if Path(str(whose)).absolute() != job.study:
        raise UsageError(
            f"{job.out} holds the results of another study, {whose}; name another folder with -o, or remove that one"
        )
    return found


def _entry(job: Job, *, state: State, reason: str = "", found: Results | None = None, duration_s: float = 0.0) -> Entry:
    """Return what became of a study, with the findings of its results; one that failed counts as an error."""
    severities = Counter(one.severity for one in found.findings) if found is not None else Counter[Severity]()
    return Entry(
        name=job.name,
        study=str(job.study),
        out=str(job.out),
        state=state,
        reason=reason,
        errors=severities[Severity.ERROR] + (state == "failed"),
        warnings=severities[Severity.WARNING],
        duration_s=duration_s,
    )


def _since(started: float) -> float:
    return round(time.monotonic() - started, 3)


def _measured(jobs: Sequence[Job], options: Options) -> Iterator[Entry]:
    with connected(options.dask, workers=options.workers) as cluster:
        if cluster is None:
            yield from map(measure_one, jobs)
            return
        for job, entry in cluster.each(measure_one, jobs):
            if entry.state == "failed" or (job.out / RESULTS).is_file():
                yield entry
            else:
                reason = f"a process of the cluster wrote {job.out}, but it is not there: is the folder shared?"
                yield replace(entry, state="failed", reason=reason, errors=1)


def _write_tables(entries: Sequence[Entry], root: Path) -> None:
    """Lay the rows of all studies under each other, one study in memory at a time."""
    part = root / "fleet.csv.part"
    with part.open("w", encoding="utf-8", newline="") as file:
        for index, entry in enumerate(entries):
            text = (Path(entry.out) / "results.csv").read_text(encoding="utf-8")
            rows = csv.reader(io.StringIO(text))
            table = csv.writer(file, lineterminator="\n")
            header = next(rows)
            if not index:
                table.writerow(["study", *header])
            table.writerows([entry.name, *row] for row in rows)
    part.replace(root / "fleet.csv")
    part = root / "fleet.parquet.part"
    writer: pq.ParquetWriter | None = None
    for entry in entries:
        table = pq.read_table(Path(entry.out) / "results.parquet")
        table = table.add_column(0, "study", pa.array([entry.name] * table.num_rows, pa.string()))
        writer = writer or pq.ParquetWriter(part, table.schema)
        writer.write_table(table)
    if writer is None:
        (root / "fleet.parquet").unlink(missing_ok=True)
    else:
        writer.close()
        part.replace(root / "fleet.parquet")


def _write(path: Path, content: bytes) -> None:
    part = path.with_name(f"{path.name}.part")
    part.write_bytes(content)
    part.replace(path)
