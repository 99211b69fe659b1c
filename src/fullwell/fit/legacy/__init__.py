"""The published estimators, biased as they are, under their own names: beside the recommended ones, never instead."""

from fullwell.fit.legacy.imatest import fit_legacy_imatest

__all__ = ["fit_legacy_imatest"]
