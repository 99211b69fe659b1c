"""A config says exactly what RESULTS 6 shows; a bad one is a sentence that names key, value and what is allowed."""

from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.simulate.config import parse_config, read_config
from fullwell.simulate.plan import plan
from fullwell.testing import simulation
from fullwell.workflow.demo import pixel_study

PUBLISHED = """
seed = 1
[camera]
width = 640
height = 480
cfa = "RGGB"
bit_depth = 12
black_level = 256             # DN
white_level = 4095
base_iso = 100
system_gain = 0.5             # DN/e- at base_iso; scales with ISO
full_well = 7000              # e-
read_noise = 2.5              # e-, before the amplifier
read_noise_post = 0.0         # DN, after it
read_noise_row = 0.0          # e-, temporal; read_noise_column likewise
dark_current = 4.0            # e-/s
dsnu = 1.0                    # e-
prnu = 0.6                    # %
channel_response = {R = 0.5, G1 = 1.0, G2 = 1.0, B = 0.6}
pixel_pitch_um = 1.4
[lens]
shading = "none"              # none, cos4, or a map file
focal_length_mm = 4.38
flare = 0.0                   # fraction of the maximum signal
[study]
isos = [100]
flat = {exposures_s = [0.002, 0.004], electrons = [1000, 2000], frames = 4}
dark = {exposures_s = [0.5, 1.0, 2.0], frames = 4}
bias = {exposures_s = [0.0001], frames = 5}
[output]
format = "dng"                # dng, tiff, headerless
compression = "none"          # none, lossless-jpeg
"""
BIAS = "[study]\nbias = {exposures_s = [0.1]}\n"


def test_the_published_example_means_what_it_says() -> None:
    config = parse_config(PUBLISHED, name="example.toml", folder=Path())
    sensor = config.sensor
    assert (sensor.width, sensor.height, sensor.cfa, sensor.bit_depth) == (640, 480, "RGGB", 12)
    assert sensor.black_level == (256.0,) * 4
    assert (sensor.prnu, sensor.dsnu, sensor.dark_current) == (0.006, 1.0, 4.0)
    assert sensor.response == (0.5, 1.0, 1.0, 0.6)
    assert len(plan(config)) == 2 * 4 + 3 * 4 + 5


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[camera]\nreed_noise = 3\n", ["camera.reed_noise = 3", "Did you mean read_noise?"]),
        ("[camra]\n", ["camra", "Did you mean camera?"]),
        ("[camera]\nread_noise = -3\n", ["camera.read_noise = -3", "0 to 1e7", "electrons"]),
        ('[camera]\ndark_current = "4 e-/s"\n', ['camera.dark_current = "4 e-/s"', "a number", "e-/s"]),
        ("[camera]\nprnu = 60\n", ["camera.prnu = 60", "0 to 20", "percent"]),
        ("[camera]\nread_noise = nan\n", ["camera.read_noise = NaN", "a number"]),
        ("[camera]\nblack_level = 5000\n", ["camera.black_level = 5000", "white_level = 4095", "below 4095"]),
        ("[camera]\nblack_level = [1, 2]\n", ["camera.black_level = [1", "list of 4"]),
        ("[camera]\nblack_level = [-5, 1, 1, 1]\n", ["camera.black_level = [-5", "from 0"]),
        ("[camera]\nwhite_level = 5000\n", ["camera.white_level = 5000", "12 bits", "4095"]),
        ('[camera]\ncfa = "RGBG"\n', ['camera.cfa = "RGBG"', "RGGB, GRBG, GBRG, BGGR or mono"]),
        ("[camera]\nwidth = 641\n", ["camera.width = 641", "even"]),
        ("[camera]\nchannel_response = {R = -1}\n", ["camera.channel_response.R = -1", "0 to 100"]),
        ("flat = {exposures_ms = [1], electrons = [1]}\n", ["study.flat.exposures_ms", "Did you mean exposures_s?"]),
        ("flat = {exposures_s = [1, -1], electrons = [1, 2]}\n", ["study.flat.exposures_s.1 = -1", "seconds"]),
        ("flat = {exposures_s = [1, 2], electrons = [1]}\n", ["study.flat.electrons = [1", "one per exposure"]),
        ("flat = {exposures_s = [1]}\n", ["study.flat.electrons is missing", "one number per exposure"]),
        ("isos = [100, 100]\n", ["study.isos = [100, 100]", "once"]),
        ('scene = {subjects = ["cat"]}\n', ['"cat"', "gradient"]),
        ("[lens]\nflare = 1.5\n", ["lens.flare = 1.5", "fraction"]),
        (
            '[output]\nformat = "tiff"\ncompression = "lossless-jpeg"\n',
            ['output.compression = "lossless-jpeg"', "none"],
        ),
    ],
)
def test_a_bad_config_is_a_sentence_with_key_value_and_range(text: str, parts: list[str]) -> None:
    with pytest.raises(UsageError) as caught:
        parse_config(BIAS + text, name="bad.toml", folder=Path())
    message = str(caught.value)
    assert message.startswith("bad.toml")
    assert "\n" not in message
    assert [part for part in parts if part not in message] == []


def test_a_config_that_is_no_toml_or_no_file_or_takes_nothing_says_so(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="not TOML"):
        parse_config("seed =", name="bad.toml", folder=tmp_path)
    with pytest.raises(UsageError, match="cannot be read"):
        read_config(tmp_path / "missing.toml")
    with pytest.raises(UsageError, match="takes no frames"):
        parse_config("seed = 1", name="bad.toml", folder=tmp_path)


def test_flats_are_compensated_for_the_iso() -> None:
    study = {"isos": [100, 300], "flat": {"exposures_s": [0.001], "electrons": [3000.0], "frames": 1}}
    base, higher = plan(simulation(study=study))
    assert (base.exposure.exposure_s, base.exposure.electrons) == (0.001, 3000.0)
    assert higher.exposure.exposure_s == 0.000333333
    rate = higher.exposure.electrons / higher.exposure.exposure_s
    assert rate == pytest.approx(3000.0 / 0.001, rel=1e-15)
    assert higher.name == "flat/ISO_300/exp000000333.333us_n00"


def test_the_pixel_study_is_the_published_one() -> None:
    config = pixel_study()
    frames = plan(config)
    measured = [frame for frame in frames if frame.kind != "scene"]
    assert len(measured) == 336
    assert (config.sensor.width, config.sensor.height) == (4032, 3024)
    assert (config.halved().sensor.width, config.halved().sensor.height) == (2016, 1512)
    assert config.halved().sensor.pixel_pitch_um == 2.8
    assert len({frame.name for frame in frames}) == len(frames)
    assert [frame.exposure.frame for frame in frames] == list(range(len(frames)))
