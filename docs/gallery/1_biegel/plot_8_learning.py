"""
Figure 8: learning from loads alone
===================================

AC load and mean torque over the rotations, wind 2 m/s faster after 22 rotations: the paper's
learner, then the adaptive one.  Computed while the site is built (``examples/13_learning.py``);
the paper goes from 2.94e4 to 2.80e3 in 20 rotations.
"""

from pitchopt.cases import load_case
from pitchopt.plotting import learning_figure
from pitchopt.studies.learning import LearningSettings, WindStep, learn

case = load_case("biegel2011")
wind = WindStep(speed=case.wind.speed, change=2.0, rotation=22)


def run(learner):
    """One run, and what became of the sum of RMS values."""
    result = learn(case, LearningSettings(learner=learner, rotations=40, wind=wind))
    print(
        f"{result.start.rms_sum:.3g} at the start, {result.rms[21].sum():.3g} after 22 rotations, "
        f"{result.ratio(22):.2f} times the design's"
    )
    return learning_figure(result, title=f"{case.name}, {learner} learner")


paper = run("paper")

# %%
# The adaptive learner, which estimates its model as it goes:

adaptive = run("adaptive")
