"""What ``fullwell --help`` and ``fullwell --version`` say: plain text, written before anything heavy loads."""

from typing import Final

from fullwell import __version__

INTERRUPTED: Final = 130

COMMANDS: Final = (
    ("characterize", "Measure a sensor from a folder of raw frames, or a study.toml."),
    ("chart", "Measure a noise model from shots of a test chart."),
    ("compare", "Set results side by side: bodies, methods, EMVA against chart."),
    ("convert", "Convert raw files to DNG or TIFF, mosaic and levels kept."),
    ("demo", "Simulate a known camera, measure it, print truth beside measurement."),
    ("fleet", "Measure many studies, on one machine or a cluster, into one table."),
    ("index", "Write a study.toml of a folder, to be corrected by hand."),
    ("inspect", "Tell what raw files are: size, CFA, levels, exposure."),
    ("loop", "Simulate a measured camera, measure it again, judge every figure."),
    ("model", "Convert noise models: k's, DN, electrons, EMVA 1288, DNG NoiseProfile."),
    ("presets", "Keep how headerless raw files are stored, by extension."),
    ("shading", "Fit, compare and apply maps of lens shading."),
    ("simulate", "Write a simulated camera's raw frames from a configuration."),
)
"""Every command with its summary, in the order they are listed."""


def version_line() -> str:
    """Return the program's name and version, with a line end."""
    return f"fullwell {__version__}\n"


def overview() -> str:
    """Return the help page of the whole program."""
    width = max(len(name) for name, _summary in COMMANDS)
    listed = "\n".join(f"  {name:<{width}}  {summary}" for name, summary in COMMANDS)
    return f"""Usage: fullwell COMMAND [OPTIONS] ...

  Measures image sensors from raw files, every figure with an honest
  uncertainty.

Commands:
{listed}

Options:
  --version  Show the version and exit.
  -h, --help Show this page and exit.

  fullwell COMMAND --help tells what a command takes. Exit status: 0 done;
  1 done, but part of the data could not be used; 2 bad use or unusable
  input; 70 a bug of ours; {INTERRUPTED} interrupted.
"""


def summary_of(command: str) -> str:
    """Return a command's one-line summary."""
    return next(summary for name, summary in COMMANDS if name == command)
