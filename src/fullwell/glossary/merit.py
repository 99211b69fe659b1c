"""Figures of merit: how much the sensor holds, and how far that stands above its noise."""

from typing import Final

from fullwell.glossary.entry import Quantity

SNR_THRESHOLDS: Final = (1.0, 10.0)
"""Signal-to-noise ratios that dynamic range is given for."""

RANGE: Final = (
    Quantity(
        name="saturation_capacity",
        title="Saturation capacity",
        symbol="μ_sat",
        units=("e-", "DN", "p"),
        definition="Largest signal that still carries information: charge (or raw values above black) at saturation.",
        equation="μ_sat = S_sat/K at the maximum of the temporal variance, or of the plateau",
        source="METHOD 7",
    ),
    Quantity(
        name="snr_max",
        title="Maximum signal-to-noise ratio",
        symbol="SNR_max",
        units=("dB", "1", "bit"),
        definition="Signal over noise at saturation; 20·log₁₀ of it in dB.",
        equation="SNR_max = S_sat/√(A + K·S_sat + C·S²_sat); shot noise alone: √μ_sat",
        source="METHOD 7",
    ),
    Quantity(
        name="dynamic_range",
        title="Dynamic range of the sensor",
        symbol="DR",
        units=("dB", "EV", "1"),
        definition="Saturation over the signal at which the signal-to-noise ratio reaches the threshold; no flare.",
        equation="DR = S_sat/S₁, (1 − s²C)·S₁² − s²K·S₁ − s²A = 0",
        source="METHOD 7",
    ),
    Quantity(
        name="camera_dynamic_range",
        title="Dynamic range of the camera",
        symbol="DR_cam",
        units=("dB", "EV"),
        definition="The same with the lens: stray light raises the noise and hides the darkest signals.",
        equation="(1 − C)·s² − (B + 2Cf)·s − (A + Bf + Cf²) = 0, f the flare",
        source="METHOD 7",
    ),
    Quantity(
        name="flare",
        title="Flare",
        symbol="f",
        units=("1",),
        definition="Stray light as a fraction of the largest signal in the scene.",
        equation="S = S_scene + f·S_max",
        source="METHOD 7",
    ),
)
