"""How a frame was taken: ISO, exposure, temperature and camera, from the tags of TIFF, EXIF and DNG."""

from dataclasses import dataclass

from fullwell.raw.directory import Directories, Directory
from fullwell.raw.tags import ISO_IN_OTHER_TAG, ISO_TAGS, Tag


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """How a frame was taken; None where the file does not say, or says 0.

    Parameters
    ----------
    iso
        ISO speed [1].
    exposure_s
        Exposure time [s].
    temperature_c
        EXIF tag Temperature: of the surroundings by its definition, of the sensor where a camera writes it so [deg C].
    make, model
        As the maker writes them.
    serial
        Of the body.
    firmware
        Tag Software: the camera's, or that of the program which wrote the file last.
    orientation
        TIFF tag Orientation, 1 where absent.

    """

    iso: float | None
    exposure_s: float | None
    temperature_c: float | None
    make: str | None
    model: str | None
    serial: str | None
    firmware: str | None
    orientation: int


def read_exposure(directories: Directories, image: Directory) -> Exposure:
    """Return how the frame was taken, looking in the image's directory, the first one and EXIF."""
    isos = [_positive(directories, image, tag) for tag in ISO_TAGS]
    known = [iso for iso in isos if iso is not None and iso != ISO_IN_OTHER_TAG]
    first = directories.first
    orientation = first.integer(Tag.ORIENTATION, 1)
    return Exposure(
        iso=known[0] if known else None,
        exposure_s=_positive(directories, image, Tag.EXPOSURE_TIME),
        temperature_c=directories.lookup(Tag.TEMPERATURE, image).number(Tag.TEMPERATURE),
        make=first.text(Tag.MAKE),
        model=first.text(Tag.MODEL) or first.text(Tag.UNIQUE_CAMERA_MODEL),
        serial=first.text(Tag.CAMERA_SERIAL_NUMBER) or directories.exif.text(Tag.BODY_SERIAL_NUMBER),
        firmware=first.text(Tag.SOFTWARE),
        orientation=orientation if 1 <= orientation <= 8 else 1,
    )


def _positive(directories: Directories, image: Directory, tag: Tag) -> float | None:
    """Return the first positive value found: an IFD0 that says 0 does not hide what EXIF knows."""
    for directory in (image, directories.first, directories.exif):
        value = directory.number(tag)
        if value is not None and value > 0:
            return value
    return None
