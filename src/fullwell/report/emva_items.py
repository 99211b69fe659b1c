"""The items of the package emva1288's result file, each with the row of ours that holds the same figure.

Tags, symbols, units and LaTeX names are the package's interface: files written by one are read by the other.
"""

from dataclasses import dataclass
from typing import Final

from fullwell.units import DECIBEL, DN, DN2, DN_PER_ELECTRON, DN_PER_SECOND, ELECTRON, ELECTRON_PER_SECOND, ONE, PERCENT


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One figure of the file.

    Parameters
    ----------
    section, tag
        Where it stands.
    short, symbol, unit, latexname
        Fields of the file; empty where it has none.
    quantity, row_unit
        The row of ours; quantity is empty where there is none.

    """

    section: str
    tag: str
    short: str
    quantity: str = ""
    row_unit: str = ""
    symbol: str = ""
    unit: str = ""
    latexname: str = ""


_E: Final = "$e^-$"
_P: Final = "$p$"
_E_PER_AREA: Final = r"$e^-/\mu m^2$"
_P_PER_AREA: Final = r"$p/\mu m^2$"
_PERCENT: Final = r"\%"
_BIT: Final = "bit"
PHOTON: Final = "p"
PER_AREA: Final = "/um^2"

# tag, short, our quantity, our unit, symbol, unit, LaTeX name
_SENSITIVITY: Final = (
    ("index_u_ysat", "Saturation index", "", "", "", "", ""),
    ("index_sensitivity_min", "First index of the sensitivity fit", "", "", "", "", ""),
    ("index_sensitivity_max", "Last index of the sensitivity fit", "", "", "", "", ""),
    ("R", "Responsivity", "responsivity", "DN/p", "R", "DN/p", ""),
    ("K", "System gain", "system_gain", DN_PER_ELECTRON, "K", "$DN/e^-$", "K"),
    ("inverse_K", "Inverse of the system gain", "conversion_factor", "e-/DN", "1/K", "$e^-/DN$", "InvK"),
    ("QE", "Quantum efficiency", "quantum_efficiency", PERCENT, r"$\eta$", _PERCENT, "QE"),
    ("sigma_y_dark", "Temporal dark noise", "dark_noise", DN, r"$\sigma_{y.dark}$", "DN", "SigmaYDark"),
    ("sigma_d", "Temporal dark noise", "dark_noise", ELECTRON, r"$\sigma_d$", _E, "SigmaDark"),
    ("u_p_min", "Sensitivity threshold", "sensitivity_threshold", PHOTON, r"$\mu_{p.min}$", _P, "UPMin"),
    (
        "u_p_min_area",
        "Sensitivity threshold per area",
        "sensitivity_threshold_per_area",
        PHOTON + PER_AREA,
        r"$\mu_{p.min.area}$",
        _P_PER_AREA,
        "UPMin",
    ),
    ("u_e_min", "Sensitivity threshold", "sensitivity_threshold", ELECTRON, r"$\mu_{e.min}$", _E, "UEMin"),
    (
        "u_e_min_area",
        "Sensitivity threshold per area",
        "sensitivity_threshold_per_area",
        ELECTRON + PER_AREA,
        r"$\mu_{e.min.area}$",
        _E_PER_AREA,
        "UEMin",
    ),
    ("u_p_sat", "Saturation capacity", "saturation_capacity", PHOTON, r"$\mu_{p.sat}$", _P, "UPSat"),
    (
        "u_p_sat_area",
        "Saturation capacity per area",
        "saturation_capacity_per_area",
        PHOTON + PER_AREA,
        r"$\mu_{p.sat.area}$",
        _P_PER_AREA,
        "UPSat",
    ),
    ("u_e_sat", "Saturation capacity", "saturation_capacity", ELECTRON, r"$\mu_{e.sat}$", _E, "UESat"),
    (
        "u_e_sat_area",
        "Saturation capacity per area",
        "saturation_capacity_per_area",
        ELECTRON + PER_AREA,
        r"$\mu_{e.sat.area}$",
        _E_PER_AREA,
        "UESat",
    ),
    ("SNR_max", "Maximum signal-to-noise ratio", "snr_max", ONE, "$SNR_{max}$", "", "SNRMax"),
    ("SNR_max_dB", "Maximum signal-to-noise ratio in dB", "snr_max", DECIBEL, "$SNR_{max.dB}$", "dB", "SNRMaxDB"),
    ("SNR_max_bit", "Maximum signal-to-noise ratio in bits", "snr_max", _BIT, "$SNR_{max.bit}$", _BIT, "SNRMaxBit"),
    (
        "inverse_SNR_max",
        "Inverse maximum signal-to-noise ratio",
        "inverse_snr_max",
        PERCENT,
        "$SNR_{max}^{-1}$",
        _PERCENT,
        "InvSNRMax",
    ),
    ("DR", "Dynamic range", "dynamic_range", ONE, "DR", "", "DR"),
    ("DR_dB", "Dynamic range", "dynamic_range", DECIBEL, "$DR_{dB}$", "dB", "DRDB"),
)
_LINEARITY: Final = (
    ("index_linearity_min", "First index of the linearity fit", "", "", "", "", ""),
    ("index_linearity_max", "Last index of the linearity fit", "", "", "", "", ""),
    ("LE_min", "Smallest linearity error", "linearity_error_min", PERCENT, "$LE_{min}$", _PERCENT, "LEMin"),
    ("LE_max", "Largest linearity error", "linearity_error_max", PERCENT, "$LE_{max}$", _PERCENT, "LEMax"),
)
_DARK_CURRENT: Final = (
    ("u_I_mean", "Dark current from mean", "dark_current", ELECTRON_PER_SECOND, r"$\mu_{I.mean}$", "$e^-/s$", ""),
    ("u_I_mean_DN", "Dark current from mean", "dark_current", DN_PER_SECOND, r"$\mu_{I.mean.DN}$", "$DN/s$", ""),
    (
        "u_I_var",
        "Dark current from variance",
        "dark_current_from_variance",
        ELECTRON_PER_SECOND,
        r"$\mu_{I.var}$",
        "$e^-/s$",
        "UIVar",
    ),
    (
        "u_I_var_DN",
        "Dark current from variance",
        "dark_current_from_variance",
        DN_PER_SECOND,
        r"$\mu_{I.var.DN}$",
        "$DN/s$",
        "UIVar",
    ),
)
_PATTERN: Final = (
    ("DSNU1288", "DSNU", "dsnu", ELECTRON, "$DSNU_{1288}$", _E, "DSNU"),
    ("DSNU1288_DN", "DSNU in DN", "dsnu", DN, "$DSNU_{1288.DN}$", "DN", "DSNUDN"),
    ("DSNU1288_row", "DSNU of rows", "dsnu_row", ELECTRON, "$DSNU_{1288.row}$", _E, "DSNUrow"),
    ("DSNU1288_col", "DSNU of columns", "dsnu_column", ELECTRON, "$DSNU_{1288.col}$", _E, "DSNUcol"),
    ("DSNU1288_pixel", "DSNU of pixels", "dsnu_pixel", ELECTRON, "$DSNU_{1288.pixel}$", _E, "DSNUpixel"),
    ("PRNU1288", "PRNU", "prnu", PERCENT, "$PRNU_{1288}$", _PERCENT, "PRNU"),
    ("PRNU1288_row", "PRNU of rows", "prnu_row", PERCENT, "$PRNU_{1288.row}$", _PERCENT, "PRNUrow"),
    ("PRNU1288_col", "PRNU of columns", "prnu_column", PERCENT, "$PRNU_{1288.col}$", _PERCENT, "PRNUcol"),
    ("PRNU1288_pixel", "PRNU of pixels", "prnu_pixel", PERCENT, "$PRNU_{1288.pixel}$", _PERCENT, "PRNUpixel"),
)
_VARIANCES: Final = (
    ("sigma_2_y_stack", "Temporal variance of the stack", r"$\sigma^2_{y.stack}$", "stack_temporal_variance"),
    ("s_2_y_measured", "Spatial variance as measured", "$s^2_{y.measured}$", "stack_measured_variance"),
    ("s_2_y", "Spatial variance", "$s^2_{y}$", "stack_variance"),
    ("s_2_y_cav", "Spatial variance of column means", "$s^2_{y.cav}$", "stack_column_means_variance"),
    ("s_2_y_rav", "Spatial variance of row means", "$s^2_{y.rav}$", "stack_row_means_variance"),
    ("s_2_y_col", "Spatial variance of columns", "$s^2_{y.col}$", "stack_column_variance"),
    ("s_2_y_row", "Spatial variance of rows", "$s^2_{y.row}$", "stack_row_variance"),
    ("s_2_y_pixel", "Spatial variance of pixels", "$s^2_{y.pixel}$", "stack_pixel_variance"),
)


def _items(section: str, table: tuple[tuple[str, str, str, str, str, str, str], ...]) -> tuple[Item, ...]:
    return tuple(
        Item(
            section=section,
            tag=tag,
            short=short,
            quantity=quantity,
            row_unit=row_unit,
            symbol=symbol,
            unit=unit,
            latexname=latexname,
        )
        for tag, short, quantity, row_unit, symbol, unit, latexname in table
    )


ITEMS: Final = (
    Item(section="info", tag="index_start", short="Start of indices"),
    *_items("sensitivity", _SENSITIVITY),
    *_items("linearity", _LINEARITY),
    *_items("dark_current", _DARK_CURRENT),
    *(
        Item(
            section="spatial",
            tag=f"{tag}{end}",
            short=f"{short}{words}",
            quantity=f"{quantity}_{light}",
            row_unit=DN2,
            symbol=symbol.replace("}$", ".dark}$") if end else symbol,
            unit="DN2",
        )
        for tag, short, symbol, quantity in _VARIANCES
        for end, words, light in (("", "", "bright"), ("_dark", ", dark", "dark"))
    ),
    *_items("spatial", _PATTERN),
)
"""Every item with one value, section after section."""

HISTOGRAMS: Final = (
    ("histogram_DSNU", "DSNU histogram"),
    ("histogram_DSNU_accumulated", "accumulated DSNU histogram"),
    ("histogram_PRNU", "PRNU histogram"),
    ("histogram_PRNU_accumulated", "accumulated PRNU histogram"),
)
"""Items of the section defect_pixel: arrays of bins, values and model."""
