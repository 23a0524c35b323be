"""
Figures 7 and 8: lowest pitch against peak loads
================================================

Pitches that were tried at a breakpoint, the gust of the worst seed with and without the tuned
table, and the tables.  Run while the site is built for one weight of the load (kappa 0.03) with
**three seeds** in place of six; ``examples/23_minimum_pitch.py`` has the full study, three weights
and the IEA 15 MW.
"""

from example_figures import example

from pitchopt.plotting import minimum_pitch_figure, pitch_tables_figure
from pitchopt.studies.tuning import TuningPlant, tune_minimum_pitch

draw = example("23_minimum_pitch")
plant = TuningPlant("nrel-5mw")
result = tune_minimum_pitch(plant, kappa=0.03, seeds=(1, 2, 3))
tuned = next(point for point in result.breakpoints if point.rounds)
first = tuned.rounds[0]
gust = {
    "to begin with": first.problem.runs(first.problem.start)[0].simulation,
    "tuned": first.problem.runs([first.pitch])[0].simulation,
}
figure = minimum_pitch_figure(
    draw.samples_of(first), gust, skip=plant.settings.skip, title=f"{tuned.wind_speed:.3g} m/s"
)
print(draw.percent(result.with_table.change(result.with_initial)))

# %%
# Figure 8:

tables = pitch_tables_figure({"to begin with": result.initial, "kappa 0.03": result.table})
