"""EMVA 1288: what the standard's summary asks for (EMVA1288 10.1), and what stands behind it."""

from typing import Final

from fullwell.glossary.entry import Quantity

_Stack = tuple[str, str, str, str, str]
"""Name, title, definition, equation, source."""


def _stack(stack: _Stack, light: str) -> Quantity:
    """Return a signed variance of one of the two stacks."""
    name, title, definition, equation, source = stack
    return Quantity(
        name=f"{name}_{light}",
        title=f"{title}, {light} stack",
        symbol=_STACK_SYMBOLS[name],
        units=("DN^2",),
        definition=definition,
        equation=equation,
        source=source,
    )


_STACK_SYMBOLS: Final = {
    "stack_temporal_variance": "σ²_y.stack",
    "stack_measured_variance": "s²_y.measured",
    "stack_variance": "s²_y",
    "stack_row_means_variance": "s²_y.rav",
    "stack_column_means_variance": "s²_y.cav",
    "stack_row_variance": "s²_y.row",
    "stack_column_variance": "s²_y.col",
    "stack_pixel_variance": "s²_y.pixel",
}

_STACKS: Final = (
    (
        "stack_temporal_variance",
        "Temporal variance",
        "Mean over pixels of the variance over the frames of the stack.",
        "σ²_y.stack = mean of Σ(y − ⟨y⟩)²/(L − 1)",
        "EMVA1288 (65)",
    ),
    (
        "stack_measured_variance",
        "Measured spatial variance",
        "Variance over pixels of the averaged stack, temporal noise left in.",
        "s²_y.measured = Σ(⟨y⟩ − μ_y)²/(M·N)",
        "EMVA1288 (35)",
    ),
    (
        "stack_variance",
        "Spatial variance",
        "Variance over pixels of the averaged stack, temporal noise taken off. May come out negative by chance.",
        "s²_y = s²_y.measured − σ²_y.stack/L",
        "EMVA1288 (36)",
    ),
    (
        "stack_row_means_variance",
        "Variance of row means",
        "Variance of the means of the rows, temporal noise taken off. May come out negative by chance.",
        "s²_y.rav = Σ(μ[m] − μ)²/M − σ²/(L·N)",
        "EMVA1288 (41)",
    ),
    (
        "stack_column_means_variance",
        "Variance of column means",
        "Variance of the means of the columns, temporal noise taken off. May come out negative by chance.",
        "s²_y.cav = Σ(μ[n] − μ)²/N − σ²/(L·M)",
        "EMVA1288 (38)",
    ),
    (
        "stack_row_variance",
        "Spatial variance of rows",
        "The part of the spatial variance that all pixels of a row share. May come out negative by chance.",
        "s²_row = [(M·N − N)·rav − M·(s² − cav)]/(M·N − M − N)",
        "EMVA1288 (44)",
    ),
    (
        "stack_column_variance",
        "Spatial variance of columns",
        "The part of the spatial variance that all pixels of a column share. May come out negative by chance.",
        "s²_col = [(M·N − M)·cav − N·(s² − rav)]/(M·N − M − N)",
        "EMVA1288 (44)",
    ),
    (
        "stack_pixel_variance",
        "Spatial variance of pixels",
        "The part of the spatial variance that rows and columns do not explain. May come out negative by chance.",
        "s²_pixel = M·N·(s² − cav − rav)/(M·N − M − N)",
        "EMVA1288 (44)",
    ),
)

_SENSITIVITY: Final = (
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
        name="photon_transfer_offset",
        title="Offset of the photon-transfer line",
        symbol="V₀",
        units=("DN^2",),
        definition="Variance above the dark variance that the fitted photon-transfer line has without signal.",
        equation="V = V₀ + K·S",
        source="EMVA1288 (50)",
    ),
    Quantity(
        name="system_gain_regression_error",
        title="One sigma of the system gain's regression",
        symbol="σ(K)/K",
        units=("%",),
        definition="Standard deviation of the photon-transfer slope from its residuals, all taken as equal, over K.",
        equation="√[Σr²/(n − 2)/Σ(S − S̄)²]/K",
        source="EMVA1288 10.2",
    ),
    Quantity(
        name="system_gain_deviation",
        title="Deviation from one system gain",
        symbol="mean|K_i − K|/K",
        units=("%",),
        definition="Mean relative deviation of the slope of a spline through the photon transfer from K; below 3 %.",
        equation="mean|K_i − K|/K over the points up to 70 % of saturation",
        source="EMVA1288 (51)",
    ),
    Quantity(
        name="system_gain_deviation_floor",
        title="Noise floor of the deviation from one system gain",
        symbol="E mean|K_i − K|/K",
        units=("%",),
        definition="What an ideal linear camera would show for the same steps and pixels, by chance alone.",
        equation="mean of √(2/π)·SE(K_i − K)/K",
        source="EMVA1288 3",
    ),
    Quantity(
        name="dark_signal",
        title="Dark signal",
        symbol="μ_y.dark",
        units=("DN",),
        definition="Mean raw value of the dark pair at the shortest exposure.",
        equation="μ_y.dark = (μ[0] + μ[1])/2",
        source="EMVA1288 (16)",
    ),
    Quantity(
        name="dark_noise",
        title="Temporal dark noise",
        symbol="σ_d",
        units=("e-", "DN"),
        definition=(
            "Temporal noise of the dark pair at the shortest exposure: in electrons without quantization, in DN with."
        ),
        equation="σ_d = √(σ²_y.dark − 1/12)/K",
        source="EMVA1288 (53)",
        signed_twin=True,
    ),
)

_LIMITS: Final = (
    Quantity(
        name="inverse_snr_max",
        title="Inverse of the maximum signal-to-noise ratio",
        symbol="1/SNR_max",
        units=("%",),
        definition="Noise over signal at saturation, photon shot noise alone.",
        equation="1/√μ_e.sat",
        source="EMVA1288 (55)",
    ),
    Quantity(
        name="sensitivity_threshold",
        title="Absolute sensitivity threshold",
        symbol="μ_min",
        units=("e-", "p"),
        definition="Signal at which the signal-to-noise ratio is 1, or the stated threshold.",
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
        units=("e-/um^2", "p/um^2"),
        definition="The saturation capacity divided by the area of a pixel.",
        equation="μ_e.sat/A",
        source="EMVA1288 10.1",
    ),
    Quantity(
        name="saturation_level",
        title="Mean raw value at saturation",
        symbol="μ_y.sat",
        units=("DN",),
        definition="Mean raw value at which 0.1 to 0.2 % of the pixels lie at the highest code.",
        equation="μ_y at a fraction of 0.15 % at the highest code",
        source="EMVA1288 3.1",
    ),
    Quantity(
        name="saturation_exposure",
        title="Exposure time at saturation",
        symbol="t_sat",
        units=("s",),
        definition="Exposure time at which 0.1 to 0.2 % of the pixels lie at the highest code.",
        equation="t at a fraction of 0.15 % at the highest code",
        source="EMVA1288 3.1",
    ),
)

_LINEARITY: Final = (
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
        name="linearity_error_floor",
        title="Noise floor of the linearity error",
        symbol="E LE",
        units=("%",),
        definition="What an ideal linear camera would show for the same steps and pixels, by chance alone.",
        equation="mean of √(2/π)·SE(δ_i)",
        source="EMVA1288 4",
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
    Quantity(
        name="linearity_offset",
        title="Offset of the linearity line",
        symbol="a₀",
        units=("DN",),
        definition="Signal without light on the straight line of the linearity error.",
        equation="y = a₀ + a₁·H",
        source="EMVA1288 (60)",
    ),
    Quantity(
        name="linearity_slope",
        title="Slope of the linearity line",
        symbol="a₁",
        units=("DN/p", "DN/s"),
        definition="Slope of the straight line of the linearity error.",
        equation="y = a₀ + a₁·H",
        source="EMVA1288 (61)",
    ),
)

_DARK_CURRENT: Final = (
    Quantity(
        name="dark_current_from_variance",
        title="Dark current from the variance",
        symbol="μ_c.var",
        units=("e-/s", "DN^2/s", "DN/s"),
        definition="Dark current from the slope of the dark variance: valid where the mean is compensated on the chip.",
        equation="μ_c.var = slope(σ²_y.dark against t)/K²",
        source="EMVA1288 (30)",
    ),
)

EMVA: Final = (
    *_SENSITIVITY,
    *_LIMITS,
    *_LINEARITY,
    *_DARK_CURRENT,
    *(_stack(stack, light) for light in ("dark", "bright") for stack in _STACKS),
)
