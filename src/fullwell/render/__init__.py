"""A mosaic becomes a picture: levels, white balance, demosaicking, tone; and shading maps are evaluated at pixels."""
