"""One bibliography, cited by key."""

from typing import Final

from fullwell.glossary.entry import Reference

BIBLIOGRAPHY: Final = tuple(
    Reference(key=key, text=text)
    for key, text in (
        (
            "METHOD",
            "Fullwell: Method (docs/method.md). Estimators, their uncertainties, published biases.",
        ),
        (
            "EMVA1288",
            (
                "European Machine Vision Association: EMVA Standard 1288, Standard for Characterization of Image "
                "Sensors and Cameras, Release 4.0 Linear, 2021. Equations are numbered as in its release candidate "
                "of 15 March 2021."
            ),
        ),
        ("EMVA1288-PY", "emva1288, reference implementation of the standard in Python, version 1.0.2, 2023."),
        ("JANESICK2007", "J. R. Janesick: Photon Transfer: DN → λ. SPIE Press, 2007."),
        (
            "PIXEL4A",
            (
                "T.-S. Kuo, A. Vangal, P. Konda: study of the image sensor of the Google Pixel 4a, student project of "
                "Stanford PSYCH 221, 2020."
            ),
        ),
        ("IMATEST", "Imatest: measuring and modelling image sensor noise from raw files, article on its web site."),
        (
            "ISO15739",
            (
                "ISO 15739, Photography: Electronic still-picture imaging, Noise measurements. Known here from "
                "secondary sources only."
            ),
        ),
        (
            "GRAYBILL1980",
            (
                "F. A. Graybill, C.-M. Wang: Confidence intervals on nonnegative linear combinations of variances. "
                "Journal of the American Statistical Association 75 (1980) 869-873."
            ),
        ),
        (
            "PAULE1982",
            (
                "R. C. Paule, J. Mandel: Consensus values and weighting factors. Journal of Research of the National "
                "Bureau of Standards 87 (1982) 377-385."
            ),
        ),
        (
            "ASTIER2019",
            (
                "P. Astier et al.: The shape of the photon transfer curve of CCD sensors. Astronomy & Astrophysics 629 "
                "(2019) A36."
            ),
        ),
        ("DNG", "Adobe: Digital Negative (DNG) Specification."),
        ("file", "The raw files' own tags; see the levels under what was read."),
        ("user", "Given on the command line, in the manifest or with the camera."),
        ("voltage", "The camera's voltage at the white level, as given; the study under what was read names it."),
    )
)
