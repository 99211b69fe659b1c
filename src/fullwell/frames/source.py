"""Where frames come from: files that a folder or a manifest names, before anything in them is read."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from fullwell.findings import Finding
from fullwell.frames.campaign import Campaign
from fullwell.frames.series import Camera, Kind, Light
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.maker import SUFFIXES as MAKER_SUFFIXES

RAW_SUFFIXES: Final = MAKER_SUFFIXES | frozenset(
    {".dng", ".fit", ".fits", ".fts", ".gpr", ".npy", ".pgm", ".png", ".raw", ".tif", ".tiff"}
)
"""Endings of files that are taken for frames; what cannot be read among them is named in a finding."""

COMPANION_SUFFIXES: Final = frozenset(
    {
        ".json",
        ".txt",
        ".csv",
        ".tsv",
        ".md",
        ".rst",
        ".xml",
        ".xmp",
        ".toml",
        ".yaml",
        ".yml",
        ".ini",
        ".cfg",
        ".log",
        ".db",
        ".html",
        ".htm",
        ".pdf",
        ".jpg",
        ".jpeg",
        ".heic",
        ".gif",
        ".bmp",
        ".webp",
        ".mp4",
        ".mov",
        ".zip",
        ".npy",
        ".npz",
        ".m",
        ".py",
        ".ipynb",
        ".parquet",
        ".xlsx",
        ".docx",
        ".pp3",
        ".dop",
        ".thm",
        ".sha256",
        ".md5",
    }
)
"""Endings of files that commonly lie beside frames and are passed over in silence."""

PREVIEW_SUFFIXES: Final = frozenset({".jpg", ".jpeg", ".heic", ".gif", ".bmp", ".webp"})
"""Endings of pictures that a camera has processed: no noise can be measured in them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Given:
    """What a manifest states about a frame, above everything the file says; None where it states nothing.

    Parameters
    ----------
    iso, exposure_s, temperature_c
        As in `Series` [-, s, degree Celsius].
    photons
        Mean photons per pixel.
    irradiance_uw_cm2
        At the sensor, where no photons are stated [uW/cm^2].
    pulse_s
        Length of the pulse of light, where it is not the exposure [s].
    stack
        As in `Series`.
    block
        Frames of different blocks belong to different series, however close their exposures; None leaves it to them.

    """

    iso: float | None = None
    exposure_s: float | None = None
    temperature_c: float | None = None
    photons: float | None = None
    irradiance_uw_cm2: float | None = None
    pulse_s: float | None = None
    stack: bool | None = None
    block: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A file that should be a frame.

    Parameters
    ----------
    name
        Path relative to the study, with forward slashes.
    headers
        Of its frames, where they have been read already; none where they have not.

    """

    name: str
    path: Path
    kind: Kind
    given: Given = field(default_factory=Given)
    headers: tuple[RawHeader, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """What a folder or a manifest offers.

    Parameters
    ----------
    root
        Folder that names are relative to.
    camera
        Facts of the manifest.
    candidates
        Sorted by name and kind.
    findings
        What the search brought to light.
    headerless
        How the manifest says files without a header are stored.
    light
        What flats were taken under.
    campaign
        What an EMVA 1288 datasheet says beyond what frames tell.
    descriptor
        Whether an EMVA 1288 descriptor names the files: they are monochrome unless something else is said.

    """

    root: Path
    camera: Camera
    candidates: tuple[Candidate, ...]
    findings: tuple[Finding, ...] = ()
    headerless: HeaderlessFormat | None = None
    light: Light = field(default_factory=Light)
    campaign: Campaign = field(default_factory=Campaign)
    descriptor: bool = False
