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
Share = Annotated[float, Field(ge=0.0, le=0.5, allow_inf_nan=False, description="a fraction of pixels from 0 to 0.5")]
Celsius = Annotated[
    float, Field(ge=-273.0, le=200.0, allow_inf_nan=False, description="a number from -273 to 200, in deg C")
]
Coefficient = Annotated[float, Field(ge=-10.0, le=10.0, allow_inf_nan=False, description="a number from -10 to 10")]
Margin = Annotated[int, Field(ge=0, le=4096, description="an even whole number from 0 to 4096, in pixels")]
BlackLevel = Annotated[
    Level | list[Level], Field(description="a number from 0 up to below white_level, in DN, or one per CFA site")
]
SystemGain = Annotated[
    float, Field(gt=0.0, le=1000.0, allow_inf_nan=False, description="a number above 0 and up to 1000, in DN/e-")
]
Rate = Annotated[float, Field(ge=0.0, le=1e7, allow_inf_nan=False, description="a number from 0 to 1e7, in e-/s")]
Percent = Annotated[float, Field(ge=0.0, le=20.0, allow_inf_nan=False, description="a number from 0 to 20, in percent")]
Density = Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False, description="a density from 0 to 10")]
Pixel = Annotated[int, Field(ge=0, le=65535, description="an even whole number of pixels")]
Folder = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$", description="letters, digits, _ and -")]


class Table(BaseModel):
    """Any table: no key but those it has, no value of another type."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class ChannelTable(Table):
    """Response per channel."""

    R: Response = 1.0
    G1: Response = 1.0
    G2: Response = 1.0
    B: Response = 1.0
    mono: Response = 1.0


class ExponentTable(Table):
    """Power of the lens's fall-off per channel."""

    R: Exponent = 1.0
    G1: Exponent = 1.0
    G2: Exponent = 1.0
    B: Exponent = 1.0
    mono: Exponent = 1.0


class IsoTable(Table):
    """One of ``[[camera.at_iso]]``: what is different at an ISO."""

    iso: Iso
    system_gain: SystemGain | None = None
    black_level: BlackLevel | None = None
    read_noise: Electrons | None = None
    read_noise_post: Level | None = None
    read_noise_row: Electrons | None = None
    read_noise_column: Electrons | None = None
    read_noise_frame: Electrons | None = None
    dsnu: Electrons | None = None
    dsnu_row: Electrons | None = None
    dsnu_column: Electrons | None = None


class CameraTable(Table):
    """``[camera]``: the sensor."""

    name: Annotated[str, Field(min_length=1, max_length=60, description="a name")] = "Fullwell simulated camera"
    width: Annotated[int, Field(ge=2, le=32768, description="a whole number from 2 to 32768, in pixels")] = 640
    height: Annotated[int, Field(ge=2, le=32768, description="a whole number from 2 to 32768, in pixels")] = 480
    cfa: Annotated[
        Literal["RGGB", "GRBG", "GBRG", "BGGR", "mono"], Field(description="RGGB, GRBG, GBRG, BGGR or mono")
    ] = "RGGB"
    bit_depth: Annotated[int, Field(ge=8, le=16, description="a whole number from 8 to 16, in bits")] = 12
    black_level: BlackLevel = 256
    white_level: Annotated[
        int | None,
        Field(ge=1, le=65535, description="a whole number above black_level and up to 2^bit_depth - 1, in DN"),
    ] = None
    base_iso: Iso = 100
    system_gain: SystemGain = 0.5
    full_well: Annotated[
        float, Field(gt=0.0, le=1e7, allow_inf_nan=False, description="a number above 0 and up to 1e7, in electrons")
    ] = 7000.0
    read_noise: Electrons = 2.5
    read_noise_post: Level = 0.0
    read_noise_row: Electrons = 0.0
    read_noise_column: Electrons = 0.0
    read_noise_frame: Electrons = 0.0
    rts_pixels: Share = 0.0
    rts_amplitude: Electrons = 0.0
    dark_current: Rate = 0.0
    dark_current_spread: Rate = 0.0
    dark_current_doubling_c: Annotated[
        float | None, Field(gt=0.0, le=100.0, allow_inf_nan=False, description="a number above 0 and up to 100, in K")
    ] = None
    dark_current_reference_c: Celsius = 20.0
    hot_pixels: Share = 0.0
    hot_pixel_current: Rate = 0.0
    dsnu: Electrons = 0.0
    dsnu_row: Electrons = 0.0
    dsnu_column: Electrons = 0.0
    prnu: Percent = 0.0
    prnu_row: Percent = 0.0
    prnu_column: Percent = 0.0
    nonlinearity: Annotated[
        float, Field(ge=-20.0, le=20.0, allow_inf_nan=False, description="a number from -20 to 20, in percent")
    ] = 0.0
    blooming: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False, description="a fraction from 0 to 1")] = 0.0
    brighter_fatter: Annotated[
        float, Field(ge=0.0, le=1e-4, allow_inf_nan=False, description="a number from 0 to 1e-4, per electron")
    ] = 0.0
    dual_conversion_ratio: Annotated[
        float | None, Field(gt=1.0, le=64.0, allow_inf_nan=False, description="a number above 1 and up to 64")
    ] = None
    channel_response: ChannelTable = ChannelTable()
    colour_matrix: Annotated[
        list[list[Coefficient]] | None,
        Field(description="three rows of three numbers from -10 to 10: R, G and B of the camera from linear sRGB"),
    ] = None
    pixel_pitch_um: Annotated[
        float, Field(gt=0.0, le=1000.0, allow_inf_nan=False, description="a number above 0 and up to 1000, in um")
    ] = 1.4
    voltage_swing_v: Annotated[
        float | None, Field(gt=0.0, le=100.0, allow_inf_nan=False, description="a number above 0 and up to 100, in V")
    ] = None
    at_iso: Annotated[list[IsoTable], Field(description="tables of iso and what is different there")] = []


class LensTable(Table):
    """``[lens]``: shading and flare."""

    shading: Annotated[
        str, Field(min_length=1, description="none, cos4, or the path of an .npy, .npz or libcamera .json file")
    ] = "none"
    colour_temperature: Annotated[
        float, Field(ge=1000.0, le=20000.0, description="a number from 1000 to 20000, in K")
    ] = 5000.0
    shading_exponent: ExponentTable = ExponentTable()
    focal_length_mm: Annotated[
        float, Field(gt=0.0, le=1e5, allow_inf_nan=False, description="a number above 0 and up to 1e5, in mm")
    ] = 4.38
    flare: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False, description="a fraction from 0 to below 1")] = (
        0.0
    )
    defocus: Annotated[
        float, Field(ge=0.0, le=50.0, allow_inf_nan=False, description="a number from 0 to 50, in pixels")
    ] = 0.0


class DarkTable(Table):
    """``dark`` or ``bias`` of ``[study]``: exposures without light."""

    exposures_s: Annotated[
        list[Seconds], Field(min_length=1, description="a list of one or more exposures, in seconds")
    ]
    frames: FrameCount = 4


class FlatTable(DarkTable):
    """``flat`` or ``chart`` of ``[study]``: exposures to light."""

    electrons: Annotated[list[Electrons], Field(min_length=1, description="one number per exposure, in electrons")]


class SceneTable(Table):
    """``scene`` of ``[study]``: pictures of something, at the lowest ISO."""

    subjects: Annotated[list[str], Field(min_length=1, description="a list of names of subjects")]
    exposure_s: Seconds = 0.01
    electrons: Electrons = 3000.0


class SeriesTable(Table):
    """One of ``[[study.series]]``: frames that are taken exactly as it says, whatever the ISO."""

    kind: Annotated[
        Literal["flat", "dark", "bias", "chart", "scene"], Field(description="flat, dark, bias, chart or scene")
    ]
    iso: Iso
    exposure_s: Seconds
    electrons: Electrons = 0.0
    frames: FrameCount = 1
    subject: Annotated[str | None, Field(min_length=1, description="the name of a subject, for a scene")] = None
    temperature_c: Celsius | None = None


class FolderTable(Table):
    """``folders`` of ``[study]``: what each kind's folder is called."""

    flat: Folder = "flat"
    dark: Folder = "dark"
    bias: Folder = "bias"
    chart: Folder = "chart"
    scene: Folder = "scene"


class StudyTable(Table):
    """``[study]``: what is taken."""

    isos: Annotated[list[Iso], Field(min_length=1, description="a list of whole numbers from 1 to 65534")] = [100]
    flat: FlatTable | None = None
    dark: DarkTable | None = None
    bias: DarkTable | None = None
    chart: FlatTable | None = None
    scene: SceneTable | None = None
    series: Annotated[list[SeriesTable], Field(description="tables of kind, iso, exposure_s, electrons, frames")] = []
    temperature_c: Celsius | None = None
    folders: FolderTable = FolderTable()


class MarginTable(Table):
    """``optical_black`` of ``[output]``: pixels around the visible ones that see no light."""

    left: Margin = 0
    top: Margin = 0
    right: Margin = 0
    bottom: Margin = 0


class OutputTable(Table):
    """``[output]``: what files are written."""

    optical_black: MarginTable = MarginTable()
    companding_bits: Annotated[
        int | None, Field(ge=4, le=15, description="a whole number from 4 to below bit_depth, in bits")
    ] = None
    noise_profile: bool = False
    preview: bool = False

    format: Annotated[Literal["dng", "tiff", "headerless"], Field(description="dng, tiff or headerless")] = "dng"
    compression: Annotated[Literal["none", "lossless-jpeg"], Field(description="none or lossless-jpeg")] = "none"


class PatchTable(Table):
    """One of ``patches`` of ``[chart]``: a rectangle of one density."""

    name: Annotated[str, Field(min_length=1, description="a name")]
    x: Pixel
    y: Pixel
    width: Pixel
    height: Pixel
    density: Density | None = None
    """None for a patch that nobody knows the density of: it is as light as the lightest."""


class ChartTable(Table):
    """``[chart]``: what the frames of kind chart show."""

    name: Annotated[
        str | None, Field(min_length=1, description="the name of a chart Fullwell knows, or the path of a chart's TOML")
    ] = None
    densities: Annotated[
        list[Density] | str | None,
        Field(description="a list of densities from 0 to 10, or the path of a file that ends each line with one"),
    ] = None
    columns: Annotated[int | None, Field(ge=1, le=400, description="a whole number from 1 to 400")] = None
    fill: Annotated[
        float, Field(gt=0.0, le=1.0, description="a fraction above 0 and up to 1, of a patch in its spacing")
    ] = 0.8
    margin: Annotated[
        float, Field(ge=0.0, lt=0.5, description="a fraction from 0 to below 0.5, of the frame around the chart")
    ] = 0.2
    surround: Annotated[
        Density | None, Field(description="a density from 0 to 10; as the darkest patch by default")
    ] = None
    patches: list[PatchTable] = []


class ConfigTable(Table):
    """The whole file."""

    seed: Annotated[int, Field(ge=0, lt=2**63, description="a whole number from 0 to 2^63 - 1")] = 1
    camera: CameraTable = CameraTable()
    lens: LensTable = LensTable()
    chart: ChartTable = ChartTable()
    study: StudyTable = StudyTable()
    output: OutputTable = OutputTable()
