"""``fullwell simulate``: a camera as raw files on disk."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from fullwell.cli.options import Quiet, Verbose, Version, Workers, path_from
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded

_Config = Annotated[Path | None, typer.Argument(parser=path_from, metavar="CONFIG.toml", help="What to simulate.")]
_Camera = Annotated[
    str | None, typer.Option("--camera", metavar="NAME", help="Simulate a camera that ships: --list shows them.")
]
_From = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="SOURCE",
        help="Simulate what was measured or published: results.json or its folder, a DNG with a NoiseProfile, or "
        "figures as k_dark=1.672e-4,k_shot=5.554e-3,k_fpn=5.477e-3,digital_maximum=16383,black=511.",
    ),
]
_Design = Annotated[
    str | None, typer.Option("--design", metavar="chart|study", help="What is taken, where --from has figures alone.")
]
_Folder = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        parser=path_from,
        metavar="FOLDER",
        help="Folder for the frames: new, empty, or with simulated frames alone, which are replaced.",
    ),
]
_Seed = Annotated[int | None, typer.Option("--seed", metavar="N", help="Another seed is another camera of the make.")]
_Print = Annotated[bool, typer.Option("--print", help="Print the config as TOML, to be edited, and stop.")]


def _show_cameras(value: bool) -> None:  # noqa: FBT001 - Typer hands an option's value to its callback by position
    if value:
        from fullwell.simulate.config import CAMERAS, shipped_summary  # noqa: PLC0415 - heavy, `--help` needs none

        width = max(map(len, CAMERAS))
        for name in CAMERAS:
            sys.stdout.write(f"{name:<{width}}  {shipped_summary(name)}\n")
        raise typer.Exit


_List = Annotated[
    bool, typer.Option("--list", callback=_show_cameras, is_eager=True, help="List the cameras that ship, and exit.")
]


def simulate(
    config: _Config = None,
    *,
    camera: _Camera = None,
    source: _From = None,
    design: _Design = None,
    out: _Folder = None,
    seed: _Seed = None,
    show: _Print = False,
    workers: Workers = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _list: _List = False,
    _version: Version = False,
) -> None:
    """Write a simulated camera's frames."""
    with guarded(verbose=verbose):
        from fullwell.errors import UsageError  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.simulate.config import shipped_text  # noqa: PLC0415 - as above
        from fullwell.simulate.config_text import config_text  # noqa: PLC0415 - as above
        from fullwell.workflow.simulation.simulate import simulate_config  # noqa: PLC0415 - as above
        from fullwell.workflow.simulation.source import chosen_camera  # noqa: PLC0415 - as above

        if out is None and not show:
            raise UsageError("Name a folder for the frames with --out FOLDER (or look at the config with --print).")
        made = chosen_camera(config=config, camera=camera, source=source, design=design, seed=seed)
        for sentence in () if quiet else made.said:
            sys.stderr.write(f"Assumed: {sentence}.\n")
        if out is None or show:
            sys.stdout.write(shipped_text(camera) if camera and seed is None else config_text(made.config.table))
            return
        with shown_progress(quiet=quiet) as progress:
            written = simulate_config(made.config, out, workers=workers or os.cpu_count() or 1, progress=progress)
        if not quiet:
            sys.stdout.write(f"Wrote {len(written.frames)} frames into {out}, with config.toml and truth.json.\n")
            sys.stdout.write(f"Measure them: {_how(written.root, charts=written.config.chart is not None)}\n")


def _how(root: Path, *, charts: bool) -> str:
    """Return the command that measures what was written."""
    patches = sorted(root.glob("chart/*/PATCHES.csv")) if charts else []
    if patches and not [folder for folder in root.iterdir() if folder.is_dir() and folder.name != "chart"]:
        return f"fullwell chart {patches[0].parent}/*.dng --patches {patches[0]} -o OUT"
    return f"fullwell characterize {root} -o OUT"
