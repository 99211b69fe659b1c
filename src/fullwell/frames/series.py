"""An experiment: frames of one kind, ISO and exposure are a series; series are a study."""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Final, Self

from fullwell.errors import RawFileError
from fullwell.findings import Finding
from fullwell.frames.campaign import Campaign
from fullwell.raw.image import Levels, RawHeader

CONTAINER_BITS: Final = 16
"""Bits of a code where a file says no more than how it stores one."""

HIGHEST_CODE: Final = 2**CONTAINER_BITS - 1
"""No level lies above it [DN]."""

SeriesKey = (
    tuple[str, float, float] | tuple[str, float, float, float, bool] | tuple[str, float, float, float, bool, float]
)
"""What identifies and orders a series: kind, ISO, exposure, then photons and stack where they are known, then the
temperature where a study has several."""


class Kind(StrEnum):
    """What a frame was taken for."""

    FLAT = "flat"
    DARK = "dark"
    BIAS = "bias"
    CHART = "chart"
    SCENE = "scene"


MEASURED_KINDS: Final = (Kind.FLAT, Kind.DARK, Kind.BIAS)
"""Frames of an even field or of none: what series are reduced from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One raw file of a study.

    Parameters
    ----------
    name
        Path relative to the study, with forward slashes, and ``#`` with a number for one of many frames in a file: the
        frame's identity and its order.
    header
        What the file says about itself.
    size
        Bytes of the file, or of the part of it that holds this frame.

    """

    name: str
    header: RawHeader
    size: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """Frames of one kind at one ISO and exposure, in the order of their names.

    Parameters
    ----------
    kind, iso, exposure_s
        What the frames have in common; ``iso`` is None where nothing says it. Frames of a bias series may lack
        an exposure; flat and dark frames never do.
    temperature_c
        Mean of the frames' temperatures, None where unknown.
    photons
        Mean photons per pixel, where calibrated.
    frames
        Sorted by name.
    stack
        True for a stack of frames that shows the fixed pattern, False for a pair that shows the temporal noise, as
        EMVA 1288 keeps them apart; None for frames that serve as both.
    condition_c
        Temperature that tells the series from those at another one, None where the study has one only.

    """

    kind: Kind
    iso: float | None
    exposure_s: float | None
    frames: tuple[Frame, ...]
    temperature_c: float | None = None
    photons: float | None = None
    stack: bool | None = None
    condition_c: float | None = None

    @property
    def key(self) -> SeriesKey:
        """Return what identifies and orders the series within a study."""
        known = (self.kind.value, self.iso or 0.0, self.exposure_s or 0.0)
        if self.condition_c is not None:
            return (*known, self.photons or 0.0, self.stack or False, self.condition_c)
        if self.photons is None and self.stack is None:
            return known
        return (*known, self.photons or 0.0, self.stack or False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """Facts about the camera that raw files do not carry; None where nobody gave them.

    Parameters
    ----------
    pixel_area_um2
        Area of a pixel; None is the square of the pitch [um^2].
    voltage_swing_v
        Voltage at the white level [V].
    base_iso
        ISO at which the amplification is 1.

    """

    name: str | None = None
    bit_depth: int | None = None
    cfa: str | None = None
    black_level: tuple[float, ...] | None = None
    white_level: float | None = None
    pixel_pitch_um: float | None = None
    pixel_area_um2: float | None = None
    voltage_swing_v: float | None = None
    base_iso: float | None = None
    focal_length_mm: float | None = None

    @property
    def area_um2(self) -> float | None:
        """Return the area of a pixel, None where nothing tells it [um^2]."""
        if self.pixel_area_um2 is not None or self.pixel_pitch_um is None:
            return self.pixel_area_um2
        return self.pixel_pitch_um**2


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """The light that flats were taken under, as far as it is known.

    Parameters
    ----------
    wavelength_nm, fwhm_nm
        Centroid and full width at half maximum of the spectrum [nm].
    irradiance_uw_cm2
        At the sensor [uW/cm^2].
    nonuniformity_percent
        Largest minus smallest irradiance over the sensor, over the mean [%].
    calibration_error_percent
        Of the absolute calibration of the irradiance, one standard error [%].
    control
        What the sweep varies: ``time``, ``light`` or ``pulse``; None where it shows in the series.
    nominal
        True where photons are nominal: proportional to the exposure, but not calibrated.

    """

    wavelength_nm: float | None = None
    fwhm_nm: float | None = None
    irradiance_uw_cm2: float | None = None
    nonuniformity_percent: float | None = None
    calibration_error_percent: float | None = None
    control: str | None = None
    nominal: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Exclusion:
    """A file that was left out, and why."""

    name: str
    code: str
    reason: str

    @classmethod
    def of(cls, name: str, error: RawFileError | OSError) -> Self:
        """Return a file that could not be read or decoded."""
        if isinstance(error, RawFileError):
            return cls(name=name, code=error.code, reason=error.message)
        if isinstance(error, FileNotFoundError):
            return cls(name=name, code="file-missing", reason="the file does not exist")
        reason = f"the file cannot be read ({error.strerror or error})"
        return cls(name=name, code="file-unreadable", reason=reason)


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """An experiment: every usable frame in its series, what all frames share, and what was left out.

    Parameters
    ----------
    root
        Folder that frame names are relative to.
    camera
        Facts given by the manifest, ``--camera`` or nobody.
    series
        Sorted by key.
    width, height, cfa, bit_depth
        What every frame has in common [pixel, pixel, order, bit].
    black_level, white_level
        Declared levels per CFA site, from the user, the manifest or the files' metadata (`Levels.source` says which);
        None where nobody declared them.
    excluded
        Files that were left out, each with its reason.
    findings
        What indexing brought to light.
    light
        What flats were taken under.
    campaign
        What an EMVA 1288 datasheet says beyond what frames tell.
    descriptor
        Whether the study is an EMVA 1288 descriptor's.

    """

    root: Path
    camera: Camera
    series: tuple[Series, ...]
    width: int
    height: int
    cfa: str
    bit_depth: int
    black_level: Levels | None
    white_level: Levels | None
    excluded: tuple[Exclusion, ...] = ()
    findings: tuple[Finding, ...] = ()
    light: Light = field(default_factory=Light)
    campaign: Campaign = field(default_factory=Campaign)
    descriptor: bool = False

    @property
    def isos(self) -> tuple[float | None, ...]:
        """Return the distinct ISOs in ascending order, unknown first."""
        return tuple(sorted({series.iso for series in self.series}, key=lambda iso: iso or 0.0))

    def select(self, *kinds: Kind, iso: float | None) -> tuple[Series, ...]:
        """Return the series of some kinds at one ISO, by ascending exposure."""
        chosen = [series for series in self.series if series.kind in kinds and series.iso == iso]
        return tuple(sorted(chosen, key=lambda series: (series.exposure_s or 0.0, series.key)))
