"""What ``--dry-run --json`` prints: the study as it would be read."""

import json
from dataclasses import asdict

from fullwell.frames.series import Study


def plan_json(study: Study) -> str:
    """Return what of a study would be read and measured, as JSON text with a line end."""
    document = {
        "schema": "fullwell-plan/1",
        "camera": {name: value for name, value in asdict(study.camera).items() if value is not None},
        "width": study.width,
        "height": study.height,
        "cfa": study.cfa,
        "bit_depth": study.bit_depth,
        "black_level": study.black_level and asdict(study.black_level),
        "white_level": study.white_level and asdict(study.white_level),
        "series": [
            {
                "kind": series.kind.value,
                "iso": series.iso,
                "exposure_s": series.exposure_s,
                "temperature_c": series.temperature_c,
                "photons": series.photons,
                "files": [frame.name for frame in series.frames],
            }
            for series in study.series
        ],
        "excluded": [asdict(one) for one in study.excluded],
        "findings": [asdict(one) for one in study.findings],
    }
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
