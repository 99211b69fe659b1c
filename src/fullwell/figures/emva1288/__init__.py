"""EMVA 1288 figures, a file for each part of the standard; symbols of formulas are the standard's."""
