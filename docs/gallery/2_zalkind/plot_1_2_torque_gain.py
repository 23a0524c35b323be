"""
Figures 1 and 2: the torque gain by zeroth-order steps
======================================================

Estimated cost (minus mean power) with its uncertainty after the first stage and after all, the
settling function, and torque over speed.  Run in full while the site is built
(``examples/21_torque_gain.py``): 6, 8 and 10 m/s, class A, 600 s each.
"""

from example_figures import example

from pitchopt.studies.tuning import TorqueGain, TuningPlant
from pitchopt.tuning import ZerothOrder, run_study

draw = example("21_torque_gain")
problem = TorqueGain(TuningPlant("nrel-5mw", turbulence="A"))
tuner = ZerothOrder(problem.space, start=problem.start, **problem.tuner_options("zoo"))
study = run_study(problem, tuner, evaluations=tuner.most_evaluations + 1)
costs = draw.tuning_figure(problem, tuner, study.evaluations)
gain = study.best.cost / problem([1.0]).cost - 1.0
print(f"factor {study.best.x[0]:.3f}, {100 * gain:+.2f} % of power over a factor of one")

# %%
# What the generator does with the factor found:

torque = draw.winds_figure(problem, study.best.x)
