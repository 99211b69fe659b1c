"""The glossary knows every quantity, method and flag of the contract."""

import re
from pathlib import Path

import pytest

from fullwell import glossary
from fullwell.glossary.entry import Quantity

NAMES = """
black_level white_level read_noise read_noise_row read_noise_column dark_current dsnu dsnu_row dsnu_column dsnu_pixel
prnu prnu_row prnu_column prnu_pixel system_gain k_dark k_shot k_fpn saturation_capacity snr_max dynamic_range
camera_dynamic_range flare channel_ratio total_dark_noise dark_noise quantum_efficiency responsivity
sensitivity_threshold linearity_error shading_corner shading_edge_x shading_edge_y shading_residual_rms
read_noise_pre read_noise_post
"""
UNITS = {
    "black_level": "DN",
    "read_noise": "DN e- V",
    "read_noise_row": "DN e-",
    "dark_current": "DN/s e-/s V/s",
    "dsnu_row": "DN e- V",
    "prnu_pixel": "%",
    "system_gain": "DN/e-",
    "k_fpn": "1",
    "saturation_capacity": "e- DN",
    "snr_max": "dB 1",
    "dynamic_range": "dB EV 1",
    "camera_dynamic_range": "dB EV",
    "total_dark_noise": "DN e-",
    "sensitivity_threshold": "e- p",
    "linearity_error": "%",
}
METHODS = """
fused dark-frames exposure-bracket optical-black metadata user legacy-offset-ratio measured temporal-variance
pair-difference censored-likelihood legacy-pair-difference legacy-burst-mean anova mean-slope variance-slope
legacy-frame-slope dark-stack exposure-intercept emva1288-4.0-linear emva1288-4.0-linear-hp-corrected emva1288-py-1.0
legacy-intercept-std legacy-std-intercept flat-dark-stack exposure-slope two-framings legacy-slope-std photon-transfer
gamma-likelihood legacy-imatest-variance legacy-imatest-sigma temporal-variance-peak plateau legacy-max-noise-patch
noise-model shot-only legacy-patch scene-referenced iso15739-like density-fit mean-ratio p-spline radial cos4 poly44
legacy-poly22 amplification-fit
"""
FLAGS = """
recommended offset-not-identified black-clipped quantization-limited upper-limit lower-bound adc-limited model-misfit
mixed channels-differ processed drift user scaled-crop model-based
"""


@pytest.mark.parametrize("name", NAMES.split())
def test_every_quantity_of_the_contract_is_defined(name):
    entry = glossary.quantity(name)
    assert isinstance(entry, Quantity)
    assert all((entry.title, entry.symbol, entry.units, entry.equation, entry.source))
    assert entry.definition.endswith(".")
    assert set(UNITS.get(name, "").split()) <= set(entry.units)


@pytest.mark.parametrize("name", METHODS.split())
def test_every_method_of_the_contract_is_defined_and_a_published_one_says_its_bias(name):
    entry = glossary.method(name)
    assert entry is not None
    assert entry.definition.endswith(".")
    assert bool(entry.bias) == name.startswith("legacy-")


@pytest.mark.parametrize("name", FLAGS.split())
def test_every_flag_of_the_contract_is_defined(name):
    entry = glossary.flag(name)
    assert entry is not None
    assert entry.definition.endswith(".")


def test_names_are_unique():
    for table in (glossary.QUANTITIES, glossary.METHODS, glossary.FLAGS):
        names = [entry.name for entry in table]
        assert len(set(names)) == len(names)


def test_every_source_leads_to_the_bibliography():
    sources = [entry.source for entry in (*glossary.QUANTITIES, *glossary.METHODS)]
    keys = {reference.key for reference in glossary.BIBLIOGRAPHY}
    assert {source.split()[0] for source in sources} <= keys


def test_every_section_cited_stands_in_the_method():
    repository = Path(__file__).resolve().parents[2]
    headings = re.findall(r"^#+ ([0-9.]*[0-9])", (repository / "docs" / "method.md").read_text("utf-8"), re.MULTILINE)
    cited = {
        section
        for path in (repository / "src").rglob("*.py")
        for sections in re.findall(r"METHOD ((?:\d+(?:\.\d+)?(?:, | and | to )?)+)", path.read_text("utf-8"))
        for section in re.findall(r"\d+(?:\.\d+)?", sections)
    }
    assert len(cited) > 30
    assert cited <= set(headings)


def test_signed_twins_have_the_squared_unit_and_only_square_roots_have_one():
    twin = glossary.quantity("read_noise_row_variance")
    assert twin is not None
    assert twin.units == ("DN^2", "e-^2")
    assert glossary.quantity("black_level_variance") is None
    assert glossary.quantity("nothing") is None
