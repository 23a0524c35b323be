"""
Figures 3, 4 and 5: the speed regulator in two dimensions
=========================================================

Natural frequency and damping of the pitch regulator for the least tower fatigue within the limit
of the generator speed, class B at 12 m/s.  Run in full while the site is built
(``examples/20_tune_speed_regulator.py``).
"""

from example_figures import example

from pitchopt.studies.tuning import SpeedRegulator, TuningPlant
from pitchopt.tuning import ZerothOrder, run_study

draw = example("20_tune_speed_regulator")
problem = SpeedRegulator(TuningPlant("nrel-5mw", turbulence="B"))
options = problem.tuner_options("zoo")
tuner = ZerothOrder(problem.space, start=problem.start, seed=1, **options)
study = run_study(problem, tuner, evaluations=tuner.most_evaluations + 1)

# %%
# Figure 3 is the first stage, figure 4 all of them, with costs and the settling function:

samples = draw.samples_figure(problem, tuner, study.evaluations)
print(f"cost {study.best.cost / problem.reference.cost:.3f} of the start's")

# %%
# The lower half of figure 4: before and after in time.

series = draw.series_figure(problem, study.best.x, (200.0, 300.0))

# %%
# Figure 5: cost, load and generator speed by kriging, and their standard deviations.

space = draw.design_space_figure(problem, study.evaluations)
