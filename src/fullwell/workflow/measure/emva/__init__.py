"""A campaign evaluated by a profile of EMVA 1288: rows, curves and findings of one ISO."""
