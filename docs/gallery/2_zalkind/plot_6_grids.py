"""
Figure 6: against grid search
=============================

Where searches from four starts end over the cost of a grid, and cost against the number of
simulations. **Shortened** while the site is built: runs of 60 s in place of 600 s, grids of 4 and
6, one repeat.  The figures to quote are those of the full run, ``examples/24_grid_comparison.py``,
whose picture and table are in :doc:`/tuning`.
"""

from pitchopt.plotting.tuning_comparison import comparison_figure
from pitchopt.studies.tuning import SpeedRegulator, TuningPlant, compare_with_grids

coarse = {"duration": 60.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
problem = SpeedRegulator(TuningPlant("nrel-5mw", turbulence="A", **coarse))
comparison = compare_with_grids(problem, grids=(4, 6), searches=((3, 7), (4, 7)), repeats=1)
figure = comparison_figure(comparison)
print(comparison.table())
