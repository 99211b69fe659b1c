"""Fullwell measures image sensors from raw files, every figure with an honest uncertainty.

The names of ``__all__`` are for users (docs/python.md). The module of each is loaded when the name is first used, so
that the command line does not wait for it; `__init__.pyi` tells type checkers the same.
"""

from importlib import import_module
from typing import Final

__version__ = "0.1.0"

_HOMES: Final = {
    "CacheChoice": "workflow.options",
    "ChannelPoints": "fit.channels",
    "Finding": "findings",
    "FullwellError": "errors",
    "Kind": "frames.series",
    "Measured": "units",
    "Options": "workflow.options",
    "RawFileError": "errors",
    "RawImage": "raw.image",
    "Results": "figures.results",
    "Row": "figures.results",
    "Selection": "frames.selection",
    "Severity": "findings",
    "ShadingData": "fit.shading.data",
    "UsageError": "errors",
    "characterize": "workflow.characterize",
    "characterize_fleet": "workflow.fleet",
    "compare_paths": "workflow.compare",
    "fit_photon_transfer": "fit.photon_transfer",
    "fit_shading": "fit.shading.selection",
    "fit_shared_curve": "fit.channels",
    "fixed_pattern_test": "fit.noise_coefficients",
    "measure": "workflow.characterize",
    "read_raw": "raw.open",
    "read_results": "report.reading",
}

__all__ = ["__version__", *_HOMES]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    """Return a public name from the module that holds it."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    return found


def __dir__() -> list[str]:
    """Return what is here, loaded or not."""
    return sorted({*globals(), *__all__})
