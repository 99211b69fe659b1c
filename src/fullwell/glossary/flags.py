"""What the flags on a row tell."""

from typing import Final

from fullwell.glossary.entry import Flag

RECOMMENDED: Final = "recommended"

FLAGS: Final = tuple(
    Flag(name=name, definition=definition)
    for name, definition in (
        (RECOMMENDED, "The figure to quote: the best estimator that these frames allow."),
        (
            "offset-not-identified",
            "Nothing but metadata tells the black level: the dark coefficient is only bounded.",
        ),
        ("black-clipped", "More than 0.1 % of the dark pixels sit on the lowest code: noise was cut off there."),
        ("quantization-limited", "The noise is so small against one code that its variance hardly tells."),
        ("upper-limit", "The true value is at most this: only the upper end of the interval is known."),
        ("lower-bound", "The true value is at least this."),
        (
            "grid-limited",
            "Read off a grid of levels: the interval is their bracket or follows from it, the error is no Student's.",
        ),
        ("adc-limited", "The rail of the converter, not the pixel, sets the limit."),
        ("model-misfit", "Goodness of fit beyond the 99 % point: the errors are scaled up, the model is in doubt."),
        ("mixed", "Temporal noise and fixed pattern could not be told apart."),
        ("channels-differ", "The colour channels disagree beyond chance, so one value for all is only a summary."),
        ("processed", "Signs of processing in the raw values."),
        ("drift", "The frames of the series move beyond chance."),
        ("user", "Rests on a value given by the user."),
        ("scaled-crop", "The frame is smaller than the published crop; crop and tiles were scaled."),
        ("interpolated", "Read between two steps of the exposure sweep: no step lies in the window."),
        ("dark-line", "Some dark signals were read off a line through the others: not every exposure has darks."),
        ("nominal", "Rests on a nominal number of photons, not on a calibrated irradiance."),
        ("model-based", "Follows from a camera fact that was not measured here, such as the voltage swing."),
    )
)
