"""Every benchmark, by name: add a line here and `make bench` runs it, keeps its figures, and the tests its check."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from benchmarks import bursts, command, decoding, emva, reduction, responses, simulation, unpacking
from benchmarks.timing import Comparison

Benchmark = Callable[[Path], list[Comparison]]
"""Given an empty folder of its own, returns lines of the table; raises where two ways disagree on a result."""

BENCHMARKS: Final[Mapping[str, Benchmark]] = {
    "series": reduction.one_series,
    "bursts": reduction.many_bursts,
    "lossless-jpeg": reduction.compressed,
    "memory": reduction.memory,
    "resume": reduction.resume,
    "decoding": decoding.uncompressed,
    "lossless-jpeg-decoding": decoding.lossless_jpeg,
    "ccdproc": bursts.against_ccdproc,
    "numpy": bursts.against_numpy,
    "dask": bursts.against_dask,
    "responses": lambda _: responses.against_reading(),
    "octave": responses.against_octave,
    "emva1288": emva.against_package,
    "unpacking": lambda _: unpacking.against_numpy(),
    "simulation": lambda _: simulation.against_numpy(),
    "command": command.small,
    "full-study": command.full_study,
}
