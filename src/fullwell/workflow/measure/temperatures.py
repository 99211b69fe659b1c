"""Other temperatures of an ISO: their dark current, its doubling, and their operation points by EMVA 1288."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.dark import DoublingFit, fit_doubling_temperature
from fullwell.frames.series import Study
from fullwell.glossary import RECOMMENDED
from fullwell.units import DN_PER_SECOND, Measured, student_975
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.dark_current import measure_dark_current
from fullwell.workflow.measure.emva.measure import measure_emva, with_recommendations
from fullwell.workflow.measure.other_units import rows_in_electrons
from fullwell.workflow.measure.section import RowWriter, Section, joined
from fullwell.workflow.measure.unlit import usable_unlit
from fullwell.workflow.measure.white_level import measure_white


@dataclass(frozen=True, slots=True, kw_only=True)
class _Point:
    """The dark current of a channel at one temperature.

    Lines through few exposures know their errors badly; such an error enters the fit as the normal error that has the
    same 95 % interval.
    """

    temperature_c: float
    measured: Measured

    @property
    def error(self) -> float:
        """Return the error that the fit takes [DN/s]."""
        low, high = self.measured.ci95 or (0.0, 0.0)
        return (high - low) / (2.0 * student_975(None))


def measure_temperatures(
    study: Study, bursts: IsoBursts, rows: Sequence[Row], *, profiles: Sequence[str] = ()
) -> Section:
    """Measure what an ISO has at other temperatures than the one it was measured at.

    Parameters
    ----------
    study, bursts
        What was taken.
    rows
        What was measured at the temperature of the bursts.
    profiles
        Profiles of EMVA 1288 to evaluate by where there are flats.

    """
    if not bursts.elsewhere:
        return Section()
    own = [row for row in rows if row.iso == bursts.iso]
    elsewhere = [_at_another(study, other, own, profiles=profiles) for other in bursts.elsewhere]
    found = joined(elsewhere)
    return joined((Section(findings=(_told(bursts),)), found, _over_temperatures(bursts, (*own, *found.rows))))


def _told(bursts: IsoBursts) -> Finding:
    others = ", ".join(f"{one.temperature_c:g}" for one in bursts.elsewhere)
    message = (
        f"frames at {bursts.label} were taken at several temperatures: figures are those at {bursts.temperature_c:g} "
        f"°C; at {others} °C dark current is measured, and by EMVA 1288 what its frames allow"
    )
    return Finding(code="several-temperatures", severity=Severity.INFO, message=message)


def _at_another(study: Study, bursts: IsoBursts, own: Sequence[Row], *, profiles: Sequence[str]) -> Section:
    whites = tuple(measure_white(study, bursts, index) for index in range(len(bursts.channels)))
    usable, said = usable_unlit(bursts, whites)
    dark = measure_dark_current(usable)
    in_dn = tuple(row for row in dark.rows if RECOMMENDED in row.flags)
    section = Section(rows=(*in_dn, *rows_in_electrons(in_dn, own).rows), findings=(*said, *dark.findings))
    if profiles and bursts.flats:
        every = replace(bursts, black_clipped=usable.black_clipped)
        emva = measure_emva(study, every, whites, profiles=profiles)
        marked = replace(emva, rows=with_recommendations(section.rows, emva.rows))
        section = joined((section, marked))
    there = f"{bursts.label} and {bursts.temperature_c:g} °C"
    findings = (replace(one, message=one.message.replace(bursts.label, there)) for one in section.findings)
    return replace(section, findings=tuple(findings))


def _over_temperatures(bursts: IsoBursts, rows: Sequence[Row]) -> Section:
    """Fit the doubling of every channel's dark current (METHOD 4.5)."""
    made: list[Row] = []
    curves: list[Curve] = []
    for channel, points in _by_channel(rows):
        fit = _fit(points)
        if fit is not None:
            made.append(_doubling_row(bursts, channel, fit))
        if channel in bursts.channels and len(points) > 1:
            curves.append(_curve(bursts, channel, points, fit))
    return joined([Section(rows=tuple(made)), *(Section(curves=(curve,)) for curve in curves)])


def _by_channel(rows: Sequence[Row]) -> Iterator[tuple[str, list[_Point]]]:
    found: dict[str, list[_Point]] = {}
    for row in rows:
        wanted = (row.quantity, row.measured.unit) == ("dark_current", DN_PER_SECOND) and RECOMMENDED in row.flags
        if wanted and row.temperature_c is not None and row.measured.std_error and row.measured.ci95:
            found.setdefault(row.channel, []).append(_Point(temperature_c=row.temperature_c, measured=row.measured))
    for channel, points in found.items():
        yield channel, sorted(points, key=lambda point: point.temperature_c)


def _fit(points: Sequence[_Point]) -> DoublingFit | None:
    """Return the fit, None where fewer than two dark currents lie above their errors, or they do not clearly rise."""
    above = [one for one in points if one.measured.value > one.error]
    if len(above) < 2 or above[-1].measured.value <= above[0].measured.value:
        return None
    temperatures = [one.temperature_c for one in points]
    fit = fit_doubling_temperature(
        temperatures,
        [one.measured.value for one in points],
        [one.error for one in points],
        reference_c=sum(temperatures) / len(temperatures),
        unit=DN_PER_SECOND,
    )
    return fit if fit.doubling_c.ci95 is not None else None


def _doubling_row(bursts: IsoBursts, channel: str, fit: DoublingFit) -> Row:
    write = RowWriter(bursts=replace(bursts, temperature_c=None)).row
    return write(
        "dark_current_doubling",
        channel,
        "temperature-fit",
        fit.doubling_c,
        source="METHOD 4.5",
        flags=("model-misfit",) if fit.misfit else (),
        recommended=True,
    )


def _curve(bursts: IsoBursts, channel: str, points: Sequence[_Point], fit: DoublingFit | None) -> Curve:
    count = len(points)
    temperatures = np.array([one.temperature_c for one in points])
    fitted: tuple[float | None, ...] = (None,) * count
    if fit is not None:
        rise = np.exp2((temperatures - temperatures.mean()) / fit.doubling_c.value)
        fitted = tuple((fit.dark_current.value * rise).tolist())
    return Curve(
        name="dark_current_temperature",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * count),
            Column(name="channel", unit="", values=(channel,) * count),
            Column(name="temperature_c", unit="degC", values=tuple(temperatures.tolist())),
            Column(name="dark_current", unit=DN_PER_SECOND, values=tuple(one.measured.value for one in points)),
            Column(name="std_error", unit=DN_PER_SECOND, values=tuple(one.measured.std_error for one in points)),
            Column(name="fitted", unit=DN_PER_SECOND, values=fitted),
        ),
    )
