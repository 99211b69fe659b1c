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
        units=("dB", "1"),
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

EMVA: Final = (
    Quantity(
        name="dark_noise",
        title="Temporal dark noise",
        symbol="σ_d",
        units=("e-", "DN"),
        definition="Temporal noise of the dark frame at the shortest exposure, in electrons without quantization.",
        equation="σ_d = √(σ²_y.dark − 1/12)/K",
        source="EMVA1288 (53)",
        signed_twin=True,
    ),
    Quantity(
        name="quantum_efficiency",
        title="Quantum efficiency",
        symbol="η",
        units=("%",),
        definition="Photo-electrons per photon that hits the pixel, at the stated wavelength.",
        equation="η = R/K",
        source="EMVA1288 (52)",
    ),
    Quantity(
        name="responsivity",
        title="Responsivity",
        symbol="R",
        units=("DN/p",),
        definition="Raw values per photon that hits the pixel.",
        equation="R = Σμ_p·S/Σμ_p²",
        source="EMVA1288 (49)",
    ),
    Quantity(
        name="sensitivity_threshold",
        title="Absolute sensitivity threshold",
        symbol="μ_min",
        units=("e-", "p"),
        definition="Signal at which the signal-to-noise ratio is 1.",
        equation="μ_e.min = √(σ²_y.dark/K² + ¼) + ½; μ_p.min = μ_e.min/η",
        source="EMVA1288 (26) (27)",
    ),
    Quantity(
        name="sensitivity_threshold_per_area",
        title="Absolute sensitivity threshold per area",
        symbol="μ_min/A",
        units=("e-/um^2", "p/um^2"),
        definition="The sensitivity threshold divided by the area of a pixel.",
        equation="μ_e.min/A",
        source="EMVA1288 10.1",
    ),
    Quantity(
        name="saturation_capacity_per_area",
        title="Saturation capacity per area",
        symbol="μ_sat/A",
        units=("e-/um^2",),
        definition="The saturation capacity divided by the area of a pixel.",
        equation="μ_e.sat/A",
        source="EMVA1288 10.1",
    ),
    Quantity(
        name="linearity_error",
        title="Linearity error",
        symbol="LE",
        units=("%",),
        definition="Mean absolute deviation of the response from a straight line, relative, between 5 % and 95 %.",
        equation="LE = mean|δ_i|, δ_i = 100·(y_i − a₀ − a₁H_i)/(a₀ + a₁H_i)",
        source="EMVA1288 (58)-(63)",
    ),
    Quantity(
        name="linearity_error_min",
        title="Largest negative deviation from linearity",
        symbol="LE_min",
        units=("%",),
        definition="Minimum of the relative deviation of the response from a straight line.",
        equation="LE_min = min δ_i",
        source="EMVA1288 (62)",
    ),
    Quantity(
        name="linearity_error_max",
        title="Largest positive deviation from linearity",
        symbol="LE_max",
        units=("%",),
        definition="Maximum of the relative deviation of the response from a straight line.",
        equation="LE_max = max δ_i",
        source="EMVA1288 (62)",
    ),
)
