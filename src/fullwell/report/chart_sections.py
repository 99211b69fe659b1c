"""The chapters on shots of a chart, drawn from these curves; each chapter appears only where its curve exists.

``chart_points``
    iso, scene, exposure, exposure_s [s], frames, patch, channel, density, mean [DN], signal [DN], variance [DN^2],
    variance_std_error [DN^2], dof, temporal_variance [DN^2], clipped, fitted [DN^2], residual, used (yes, no).
    Every patch of every channel at every exposure, 0 the brightest; ``signal`` is counted from the black level of the
    channel, ``variance`` is that of a single frame.
``chart_noise_model``
    iso, channel, dark [DN^2], shot [DN/e-], fixed_pattern, black_level [DN], digital_maximum [DN], convention,
    deviance, deviance_dof. The variance is dark + shot S + fixed_pattern S^2; channel ``all`` is the model that all
    share.
``chart_tonal_response``
    iso, channel, patch, log_exposure, log_pixel, log_signal, slope. Logarithms to base 10, black level left in and
    taken off.
``chart_bracket``
    iso, scene, channel, patch, exposure, ratio, mean [DN], signal [DN], residual, used (yes, no).

Pictures come as `ChartPicture` and `RenderedPoints`; tables from the rows.
"""
