"""How to shoot a test chart: what ``fullwell chart --guide`` prints."""

from typing import Final

GUIDE: Final = """\
How to shoot a chart for a noise model

The chart
  A transmissive chart, lit evenly from behind, with 36 patches and a density
  range of 3.5 or more tells all of it. A ColorChecker (range 1.5) tells the
  system gain, but hardly the noise in the dark.

The room
  Dark. Any light that reaches the front of the chart, or the lens from beside
  it, counts as signal. Mask all around the chart with black card.

The camera
  Lowest ISO, else the converter clips before the pixels are full. Raw, not
  compressed with loss, no noise reduction, no long-exposure subtraction.
  Focus a little off: the grain of the chart then does not count as noise.
  Chart in the middle of the frame, over half of its width at most: there the
  lens is even and its flare least. Patches of 100 x 100 pixels are plenty.
  Tripod, remote release, manual exposure, and nothing moves between shots.

The shots
  1. One shot in which the lightest patch just clips, and no second one.
     Several clipped patches fog the dark ones; none leaves saturation unknown.
  2. The same scene at 1/8 of the exposure, three stops under, better at 1/16
     too. Only this tells the black level: no fit of one exposure can. Change
     the exposure time, not the aperture.
  3. Two to eight frames of each exposure: they tell temporal noise from fixed
     pattern. From one frame k_fpn is an upper bound of the PRNU.
  4. If you want the PRNU itself: the chart shifted by ten pixels or so, shot
     again. Texture moves with the chart, the pixels stay (--separate).

Then
  fullwell chart SHOT_1.dng SHOT_2.dng ... --chart dynamic-range-36-ring -o OUT
  fullwell chart SHOT_1.dng SHOT_2.dng ... --patches PATCHES.csv -o OUT

  PATCHES.csv begins with the line patch,x,y,width,height,density: even
  numbers, counted in pixels from the top left of the visible mosaic; the
  density may be left empty. What could have been done better stands first in
  the report.
"""
