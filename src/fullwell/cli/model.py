"""``fullwell model``: one noise model in every dialect."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import Isos, Json, Quiet, Verbose, Version, path_from
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.workflow.model import Conversion
    from fullwell.workflow.model_figures import StatedFigures

_KDark = Annotated[float | None, typer.Option("--k-dark", metavar="K", help="Noise in the dark over D.")]
_KShot = Annotated[float | None, typer.Option("--k-shot", metavar="K", help="Photon noise at V = 1 over D.")]
_KFpn = Annotated[float | None, typer.Option("--k-fpn", metavar="K", help="Fixed pattern noise over signal.")]
_SystemGain = Annotated[float | None, typer.Option("--system-gain", metavar="DN/e-", help="K of EMVA 1288.")]
_ReadNoise = Annotated[
    float | None,
    typer.Option("--read-noise", metavar="e-", help="Temporal dark noise, no rounding: EMVA 1288's sigma_d."),
]
_ReadNoiseDn = Annotated[float | None, typer.Option("--read-noise-dn", metavar="DN", help="The same in DN.")]
_Dsnu = Annotated[float | None, typer.Option("--dsnu", metavar="e-", help="Spread of the offsets.")]
_DsnuDn = Annotated[float | None, typer.Option("--dsnu-dn", metavar="DN", help="The same in DN.")]
_Prnu = Annotated[float | None, typer.Option("--prnu", metavar="%", help="Spread of the responses.")]
_DarkCurrent = Annotated[float | None, typer.Option("--dark-current", metavar="e-/s", help="Its variance is i t.")]
_SaturationCapacity = Annotated[
    float | None, typer.Option("--saturation-capacity", metavar="e-", help="Electrons at saturation.")
]
_SaturationDn = Annotated[
    float | None, typer.Option("--saturation-dn", metavar="DN", help="The same in DN above the black level.")
]
_DigitalMaximum = Annotated[
    float | None,
    typer.Option("--digital-maximum", metavar="DN", help="D, what V = 1 stands for; the white level by default."),
]
_White = Annotated[float | None, typer.Option("--white", metavar="DN", help="White level; D by default.")]
_Black = Annotated[float | None, typer.Option("--black", metavar="DN", help="Black level.")]
_Step = Annotated[
    float | None, typer.Option("--step", metavar="DN", help="Distance of two codes; 1 but for rescaled files.")
]
_Exposure = Annotated[
    str | None,
    typer.Option("--exposure", metavar="TIME", help="Exposure of the frames in the dark, for example 10s or 20ms."),
]
_NoiseProfile = Annotated[
    list[str] | None,
    typer.Option(
        "--noise-profile",
        metavar="S,O",
        help="NoiseProfile of a DNG, one pair or one a plane; with --white and --black.",
    ),
]
_File = Annotated[
    Path | None,
    typer.Argument(parser=path_from, metavar="FILE", help="results.json or its folder, or a DNG with a NoiseProfile."),
]


def model(
    path: _File = None,
    *,
    k_dark: _KDark = None,
    k_shot: _KShot = None,
    k_fpn: _KFpn = None,
    system_gain: _SystemGain = None,
    read_noise: _ReadNoise = None,
    read_noise_dn: _ReadNoiseDn = None,
    dsnu: _Dsnu = None,
    dsnu_dn: _DsnuDn = None,
    prnu: _Prnu = None,
    dark_current: _DarkCurrent = None,
    exposure: _Exposure = None,
    saturation_capacity: _SaturationCapacity = None,
    saturation_dn: _SaturationDn = None,
    noise_profile: _NoiseProfile = None,
    digital_maximum: _DigitalMaximum = None,
    white: _White = None,
    black: _Black = None,
    step: _Step = None,
    iso: Isos = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Convert noise models."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.workflow.model_figures import StatedFigures  # noqa: PLC0415 - as above

        asked = selection_from(isos=iso, exposures=None if exposure is None else [exposure])
        exposure_s = _one(asked.exposures_s)
        ks = StatedFigures(k_dark=k_dark, k_shot=k_shot, k_fpn=k_fpn, noise_profile=_pairs(noise_profile or []))
        noises = replace(ks, read_noise=read_noise, read_noise_dn=read_noise_dn, dsnu=dsnu, dsnu_dn=dsnu_dn, prnu=prnu)
        charges = replace(noises, system_gain=system_gain, dark_current=dark_current, exposure_s=exposure_s)
        ends = replace(charges, saturation_capacity=saturation_capacity, saturation_dn=saturation_dn)
        figures = replace(ends, digital_maximum=digital_maximum, white=white, black=black, step=step)
        _tell(_conversion(path, figures, isos=asked.isos), as_json=as_json, quiet=quiet)


def _conversion(path: Path | None, figures: "StatedFigures", *, isos: tuple[float, ...]) -> "Conversion":
    """Convert what is in a file, or what is stated, not both."""
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.workflow.model import convert_figures, convert_file  # noqa: PLC0415 - as above
    from fullwell.workflow.model_figures import option  # noqa: PLC0415 - as above

    stated = [option(name) for name in figures.stated()] + ["--noise-profile"] * bool(figures.noise_profile)
    if path is None:
        if isos:
            raise UsageError("--iso chooses among the models of a file; figures have none.")
        return convert_figures(figures)
    if stated:
        raise UsageError(f"{path} holds its noise model; leave {stated[0]} out, or the file.")
    return convert_file(path, isos=isos)


def _one(exposures_s: tuple[float, ...]) -> float | None:
    """Return the one exposure that is stated, if any [s]."""
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it

    if len(exposures_s) > 1:
        raise UsageError("--exposure: give one exposure; a model describes the frames of one.")
    return exposures_s[0] if exposures_s else None


def _pairs(texts: list[str]) -> tuple[tuple[float, float], ...]:
    """Return (S, O) of every plane."""
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it

    said = ",".join(texts)
    try:
        values = [float(item) for item in said.split(",")] if said else []
    except ValueError as error:
        raise UsageError(f"--noise-profile {said}: give S,O as numbers.") from error
    if len(values) % 2:
        raise UsageError(f"--noise-profile {said}: give pairs, S,O for one plane or S,O,S,O,... for several.")
    return tuple(zip(values[0::2], values[1::2], strict=True))


def _tell(conversion: "Conversion", *, as_json: bool, quiet: bool) -> None:
    if as_json:
        import json  # noqa: PLC0415 - one line for those who ask for it

        from fullwell.workflow.model import document  # noqa: PLC0415 - heavy, and `--help` does not need it

        sys.stdout.write(json.dumps(document(conversion), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    elif not quiet:
        from rich.console import Console  # noqa: PLC0415 - heavy, and `--help` does not need it

        from fullwell.cli.model_tables import print_conversion  # noqa: PLC0415 - as above

        print_conversion(Console(file=sys.stdout), conversion)
    raise typer.Exit(status_of(conversion.findings))
