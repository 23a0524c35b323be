"""
Figures 3 and 4: individual pitch tuned in gain and azimuth offset
==================================================================

Samples of gain and offset at 1P and 2P, coloured by cost, and the progress of the tuner, at 7 and
25 m/s. **Shortened** while the site is built: 40 evaluations with two seeds of 120 s, in place of
100 with six seeds of 600 s.  The figures to quote are those of the full run,
``examples/22_tune_individual_pitch.py``, in :doc:`/tuning`.
"""

from pitchopt.plotting import gain_samples, individual_pitch_figure, progress_figure
from pitchopt.studies.tuning import IndividualPitchGains, individual_pitch_plant
from pitchopt.tuning import run_study
from pitchopt.tuning.methods import make_tuner

plant = individual_pitch_plant("nrel-5mw", duration=120.0, skip=30.0)
samples = {}
for speed in (7.0, 25.0):
    problem = IndividualPitchGains(plant, wind_speeds=(speed,), seeds=(1, 2))
    tuner = make_tuner("bayes", problem.space, evaluations=40)
    study = run_study(problem, tuner, evaluations=40)
    off = problem.reference.cost
    print(f"{speed:g} m/s: {100 * (study.best.cost / off - 1):+.1f} % against none")
    samples[f"{speed:g} m/s"] = gain_samples(study.evaluations, off)
figure = individual_pitch_figure(samples)

# %%
# Figure 4:

progress = progress_figure(samples)
