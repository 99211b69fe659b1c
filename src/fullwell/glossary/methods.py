"""Every estimator by the name it has in the rows, the published ones with their bias."""

from typing import Final

from fullwell.glossary.entry import Method

# name, what it does, source
_PLAIN: Final = (
    ("fused", "Weighted mean of every source of evidence; disagreement between them is told.", "METHOD 2.4"),
    ("dark-frames", "Intercept of the mean of the dark frames against exposure time.", "METHOD 2.3"),
    ("exposure-bracket", "The offset at which two exposures of one static scene are proportional.", "METHOD 2.3"),
    ("optical-black", "Mean of the masked pixels.", "METHOD 2.3"),
    ("metadata", "What the file declares; nothing in the pixels was asked.", "METHOD 2.3"),
    ("user", "Given on the command line or in the manifest.", "METHOD 2.3"),
    ("measured", "The code at which raw values pile up, or the highest code seen.", "METHOD 1.11"),
    ("temporal-variance", "Mean over pixels of the unbiased variance over the frames of a burst.", "METHOD 3.1"),
    ("pair-difference", "Spatial variance of the differences of frames, halved.", "METHOD 3.2"),
    ("censored-likelihood", "Maximum likelihood of a rounded normal whose tail below black was cut.", "METHOD 3.4"),
    (
        "anova",
        "Three-way analysis of variance over frames, rows, columns; Graybill-Wang intervals.",
        "METHOD 3.5",
    ),
    (
        "median-pixel",
        "Median over pixels of the variance over frames, over that of chi-square: telegraph pixels do not move it.",
        "METHOD 3.6",
    ),
    ("scatter-ratio", "Variance over pixels of the per-pixel variance, over that of normal noise.", "METHOD 3.6"),
    ("mean-slope", "Slope of the burst means of dark frames against exposure time.", "METHOD 4.1"),
    (
        "variance-slope",
        "Slope of the dark variance against exposure time; sees through an on-chip clamp.",
        "METHOD 4.3",
    ),
    ("temperature-fit", "Dark current against temperature: a power of two, by weighted least squares.", "METHOD 4.5"),
    ("amplification-fit", "Read-noise variance against squared amplification: a slope and a constant.", "METHOD 3.7"),
    ("dark-stack", "Spatial variance of the mean dark frame, less the temporal noise left in it.", "METHOD 5.1"),
    ("exposure-intercept", "Spread of the per-pixel intercepts over exposures, less their noise.", "METHOD 5.2"),
    (
        "flat-dark-stack",
        "Spatial variance of mean flat minus mean dark, shading and temporal noise removed.",
        "METHOD 5.1",
    ),
    ("exposure-slope", "Spread of the per-pixel slopes over exposures, shading and noise removed.", "METHOD 5.2"),
    ("two-framings", "Covariance of two framings of one chart aligned on the sensor: texture drops out.", "METHOD 1.9"),
    ("photon-transfer", "Gamma-likelihood fit of the temporal variance against signal: a line.", "METHOD 1.2"),
    (
        "gamma-likelihood",
        "Gamma-likelihood fit of temporal and spatial variances together: dark, shot and fixed-pattern parts.",
        "METHOD 1.4",
    ),
    ("temporal-variance-peak", "Signal at the largest temporal variance.", "METHOD 7"),
    ("plateau", "Mean signal under heavy over-exposure, or the rail of the converter.", "METHOD 7"),
    ("last-consistent-level", "Signal at the last level that the noise model still describes.", "METHOD 7"),
    ("noise-model", "From the fitted noise model, every source of noise included.", "METHOD 7"),
    ("shot-only", "Photon shot noise alone.", "METHOD 7"),
    ("scene-referenced", "Sensor noise model with the measured flare added.", "METHOD 7"),
    (
        "iso15739-like",
        "Clipping level over temporal noise at the black patch; not a measurement by the standard.",
        "METHOD 7",
    ),
    ("density-fit", "Fit of the chart's densities with an added constant of stray light.", "METHOD 2.2"),
    ("mean-ratio", "Ratio of mean signals above black.", "METHOD 1.10"),
    ("p-spline", "Smooth surface of penalized cubic splines.", "METHOD 6.2"),
    ("radial", "Even powers of the distance from a free centre, with tilt.", "METHOD 6.2"),
    ("cos4", "The cosine-fourth law, focal length and centre free.", "METHOD 6.2"),
    (
        "cos4-fixed",
        "The cosine-fourth law for the stated focal length about the geometric centre.",
        "METHOD 6.2",
    ),
    ("poly22", "Polynomial of degree 2 in x and y, weighted, black subtracted.", "METHOD 6.2"),
    ("poly44", "Polynomial of degree 4 in x and y.", "METHOD 6.2"),
    ("poly66", "Polynomial of degree 6 in x and y.", "METHOD 6.2"),
    ("poly88", "Polynomial of degree 8 in x and y.", "METHOD 6.2"),
    ("emva1288-4.0-linear", "As EMVA 1288 Release 4.0 Linear asks, to the letter.", "EMVA1288 4.0"),
    ("emva1288-4.0-general", "As EMVA 1288 Release 4.0 General asks, referred to the input.", "EMVA1288 4.0"),
    (
        "emva1288-4.0-linear-hp-corrected",
        "EMVA 1288 Release 4.0 Linear with the attenuation of its high-pass filter divided out.",
        "EMVA1288 4.0",
    ),
    ("emva1288-py-1.0", "As the emva1288 Python package 1.0 computes it.", "EMVA1288-PY"),
)

# name, what it does, how it is biased, source
_LEGACY: Final = (
    (
        "legacy-offset-ratio",
        "The published offset optimizer: it assumes that the darkest patch is one part in 100 000 of the brightest.",
        (
            "It declares all stray light to be pedestal: the offset is wrong by the darkest signal, +3.4 DN and dark "
            "noise +11 % at a flare of 0.024 % of the largest signal."
        ),
        "METHOD 2.2",
    ),
    (
        "legacy-pair-difference",
        "Published flow 1: spatial standard deviation of the differences of five frames over √2.",
        "Unbiased but for the quantization it leaves in (q²/12: +1.8 % at 1.5 DN).",
        "METHOD 3.2",
    ),
    (
        "legacy-burst-mean",
        "Published flow 2: spatial standard deviation of each frame minus the mean of the five.",
        (
            "The mean holds a share of each frame's own noise: the result is low by √((L−1)/L), 10.6 % for five, "
            "so that flow 1 over flow 2 is then 1.1180 exactly."
        ),
        "METHOD 3.2",
    ),
    (
        "legacy-frame-slope",
        "Published dark current: straight line through the means of single dark frames.",
        (
            "The slope is unbiased; its usual standard error ignores drift that the frames of a burst share, so that a "
            "nominal 95 % interval covers 50 % or less."
        ),
        "METHOD 4.1",
    ),
    (
        "legacy-intercept-std",
        "Published DSNU: standard deviation of the per-pixel intercepts of response against exposure.",
        "Temporal noise is left in: 2.1 to 2.8 DN where the truth is 0.40 DN (+430 % to +600 %).",
        "METHOD 5.3",
    ),
    (
        "legacy-std-intercept",
        "Published DSNU: intercept of the frames' standard deviation against exposure.",
        "Temporal noise and shading are left in: 3.3 DN where the truth is 0.4 DN.",
        "METHOD 5.3",
    ),
    (
        "legacy-slope-std",
        "Published PRNU: standard deviation of the per-pixel slopes over their mean.",
        (
            "Temporal noise is left in (tiles remove shading, not noise): 1.6 % to 2.0 % where the truth is 0.70 %; "
            "averaging G1 and G2 lowers green by a further 29 %."
        ),
        "METHOD 5.3",
    ),
    (
        "legacy-imatest-variance",
        "Published noise fit: least squares on variances weighted by the inverse squared signal or variance.",
        "Nearly unbiased with the right offset, but 1.5 to 2.5 times noisier; its intervals cover 100, 52 and 33 %.",
        "METHOD 1.5",
    ),
    (
        "legacy-imatest-sigma",
        "Published noise fit: unweighted least squares on standard deviations.",
        "Nearly unbiased with the right offset, but 1.5 to 2.5 times noisier; its intervals cover 100, 52 and 28 %.",
        "METHOD 1.5",
    ),
    (
        "legacy-max-noise-patch",
        "Published saturation: the patch of largest total noise.",
        "Quantized to the grid of patches and low: by up to 31 % on a grid of 0.2486 density.",
        "METHOD 7",
    ),
    (
        "legacy-patch",
        "Published dynamic range: from the chart patch nearest to the threshold.",
        "Quantized to the grid of patches (5 dB at 0.2486 density) and dependent on the offset.",
        "METHOD 8",
    ),
    (
        "legacy-poly22",
        "Published lens shading: unweighted polynomial of degree 2 in x and y.",
        "Too stiff for a real lens: 3.7 % rms and 14.5 % in the corners, and pure cos⁴ is missed by 36 % there.",
        "METHOD 6.2",
    ),
)

METHODS: Final = (
    *(Method(name=name, definition=definition, source=source) for name, definition, source in _PLAIN),
    *(Method(name=name, definition=what, bias=bias, source=source) for name, what, bias, source in _LEGACY),
)
