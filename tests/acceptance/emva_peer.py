"""Runs in an environment of its own that has emva1288 1.0.2, numpy < 2, pillow < 12; see test_emva_package.py.

``python emva_peer.py generate FOLDER time|light FORMAT`` lets the package's camera take a campaign.
``python emva_peer.py evaluate DESCRIPTOR`` prints the package's figures as JSON.
"""

import contextlib
import io
import json
import logging
import sys
import warnings

import numpy as np
from emva1288.camera.dataset_generator import DatasetGenerator
from emva1288.process.data import Data1288
from emva1288.process.loader import LoadImageData
from emva1288.process.parser import ParseEmvaDescriptorFile
from emva1288.process.results import Results1288


def generate(folder: str, sweep: str, image_format: str) -> None:
    """Take a campaign with fixed pattern in rows, columns and pixels."""
    np.random.seed(5)  # noqa: NPY002 - the package draws from the global generator
    rng = np.random.default_rng(5)
    height, width = 75, 101
    dsnu = rng.normal(10, 2, (height, width)) + rng.normal(0, 1.5, width) + rng.normal(0, 1, (height, 1))
    prnu = rng.normal(1, 0.01, (height, width))
    kept = {"exposure_fixed": 1e7} if sweep == "light" else {}
    DatasetGenerator(
        steps=24,
        L=12,
        outdir=folder,
        image_format=image_format,
        bit_depth=12,
        width=width,
        height=height,
        dsnu=dsnu,
        prnu=prnu,
        K=0.25,
        **kept,
    )


def evaluate(descriptor: str) -> dict[str, float | None]:
    """Return every scalar of the package."""
    logging.disable(logging.CRITICAL)
    parsed = ParseEmvaDescriptorFile(descriptor)
    data = Data1288(LoadImageData(parsed.images).data)
    results = Results1288(data.data, pixel_area=25.0)
    found = {name: entry.get("value") for name, entry in results.results.items()}
    return {name: None if value is None or np.isnan(value) else float(value) for name, value in found.items()}


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    verb, *arguments = sys.argv[1:]
    if verb == "generate":
        with contextlib.redirect_stdout(io.StringIO()):
            generate(*arguments)
    else:
        with contextlib.redirect_stdout(io.StringIO()):
            figures = evaluate(arguments[0])
        sys.stdout.write(json.dumps(figures))
