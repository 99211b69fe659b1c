"""The tables of a simulation config, as TOML has them: the only place where pydantic looks at numbers.

The description of a field is its allowed range and unit, in words: it ends up in the sentence of a bad config.
"""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Electrons = Annotated[
    float, Field(ge=0.0, le=1e7, allow_inf_nan=False, description="a number from 0 to 1e7, in electrons")
]
Response = Annotated[float, Field(ge=0.0, le=100.0, allow_inf_nan=False, description="a number from 0 to 100")]
Exponent = Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False, description="a number from 0 to 10")]
Level = Annotated[float, Field(ge=0.0, le=65535.0, allow_inf_nan=False, description="a number from 0 to 65535, in DN")]
Seconds = Annotated[
    float, Field(gt=0.0, le=86400.0, allow_inf_nan=False, description="a number above 0 and up to 86400, in seconds")
]
Iso = Annotated[int, Field(ge=1, le=65534, description="a whole number from 1 to 65534")]
FrameCount = Annotated[int, Field(ge=1, le=100_000, description="a whole number from 1 to 100000")]
Folder = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$", description="letters, digits, _ and -")]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class ChannelTable(_Table):
    """Response per channel."""

    R: Response = 1.0
    G1: Response = 1.0
    G2: Response = 1.0
    B: Response = 1.0
    mono: Response = 1.0


class ExponentTable(_Table):
    """Power of the lens's fall-off per channel."""

    R: Exponent = 1.0
    G1: Exponent = 1.0
    G2: Exponent = 1.0
    B: Exponent = 1.0
    mono: Exponent = 1.0


class CameraTable(_Table):
    """``[camera]``: the sensor."""

    name: Annotated[str, Field(min_length=1, max_length=60, description="a name")] = "Fullwell simulated camera"
    width: Annotated[int, Field(ge=2, le=32768, description="a whole number from 2 to 32768, in pixels")] = 640
    height: Annotated[int, Field(ge=2, le=32768, description="a whole number from 2 to 32768, in pixels")] = 480
    cfa: Annotated[
        Literal["RGGB", "GRBG", "GBRG", "BGGR", "mono"], Field(description="RGGB, GRBG, GBRG, BGGR or mono")
    ] = "RGGB"
    bit_depth: Annotated[int, Field(ge=8, le=16, description="a whole number from 8 to 16, in bits")] = 12
    black_level: Annotated[
        Level | list[Level], Field(description="a number from 0 up to below white_level, in DN, or one per CFA site")
    ] = 256
    white_level: Annotated[
        int | None,
        Field(ge=1, le=65535, description="a whole number above black_level and up to 2^bit_depth - 1, in DN"),
    ] = None
    base_iso: Iso = 100
    system_gain: Annotated[
        float, Field(gt=0.0, le=1000.0, allow_inf_nan=False, description="a number above 0 and up to 1000, in DN/e-")
    ] = 0.5
    full_well: Annotated[
        float, Field(gt=0.0, le=1e7, allow_inf_nan=False, description="a number above 0 and up to 1e7, in electrons")
    ] = 7000.0
    read_noise: Electrons = 2.5
    read_noise_post: Level = 0.0
    read_noise_row: Electrons = 0.0
    read_noise_column: Electrons = 0.0
    read_noise_frame: Electrons = 0.0
    dark_current: Annotated[
        float, Field(ge=0.0, le=1e7, allow_inf_nan=False, description="a number from 0 to 1e7, in e-/s")
    ] = 0.0
    dsnu: Electrons = 0.0
    prnu: Annotated[
        float, Field(ge=0.0, le=20.0, allow_inf_nan=False, description="a number from 0 to 20, in percent")
    ] = 0.0
    channel_response: ChannelTable = ChannelTable()
    pixel_pitch_um: Annotated[
        float, Field(gt=0.0, le=1000.0, allow_inf_nan=False, description="a number above 0 and up to 1000, in um")
    ] = 1.4
    voltage_swing_v: Annotated[
        float | None, Field(gt=0.0, le=100.0, allow_inf_nan=False, description="a number above 0 and up to 100, in V")
    ] = None


class LensTable(_Table):
    """``[lens]``: shading and flare."""

    shading: Annotated[str, Field(min_length=1, description="none, cos4, or the path of an .npy file")] = "none"
    shading_exponent: ExponentTable = ExponentTable()
    focal_length_mm: Annotated[
        float, Field(gt=0.0, le=1e5, allow_inf_nan=False, description="a number above 0 and up to 1e5, in mm")
    ] = 4.38
    flare: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False, description="a fraction from 0 to below 1")] = (
        0.0
    )


class DarkTable(_Table):
    """``dark`` or ``bias`` of ``[study]``: exposures without light."""

    exposures_s: Annotated[
        list[Seconds], Field(min_length=1, description="a list of one or more exposures, in seconds")
    ]
    frames: FrameCount = 4


class FlatTable(DarkTable):
    """``flat`` of ``[study]``: exposures to even light."""

    electrons: Annotated[list[Electrons], Field(min_length=1, description="one number per exposure, in electrons")]


class SceneTable(_Table):
    """``scene`` of ``[study]``: pictures of something, at the lowest ISO."""

    subjects: Annotated[list[str], Field(min_length=1, description="a list of names of subjects")]
    exposure_s: Seconds = 0.01
    electrons: Electrons = 3000.0


class FolderTable(_Table):
    """``folders`` of ``[study]``: what each kind's folder is called."""

    flat: Folder = "flat"
    dark: Folder = "dark"
    bias: Folder = "bias"
    scene: Folder = "scene"


class StudyTable(_Table):
    """``[study]``: what is taken."""

    isos: Annotated[list[Iso], Field(min_length=1, description="a list of whole numbers")] = [100]
    flat: FlatTable | None = None
    dark: DarkTable | None = None
    bias: DarkTable | None = None
    scene: SceneTable | None = None
    folders: FolderTable = FolderTable()


class OutputTable(_Table):
    """``[output]``: what files are written."""

    format: Annotated[Literal["dng", "tiff", "headerless"], Field(description="dng, tiff or headerless")] = "dng"
    compression: Annotated[Literal["none", "lossless-jpeg"], Field(description="none or lossless-jpeg")] = "none"


class ConfigTable(_Table):
    """The whole file."""

    seed: Annotated[int, Field(ge=0, lt=2**63, description="a whole number from 0 to 2^63 - 1")] = 1
    camera: CameraTable = CameraTable()
    lens: LensTable = LensTable()
    study: StudyTable = StudyTable()
    output: OutputTable = OutputTable()
