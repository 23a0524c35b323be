"""Plots: results to Axes.

``plot_x(result, *, ax=None) -> Axes`` draws and returns; it never shows, saves or changes
matplotlib's settings.  `figures` puts several of them on one page.
"""

from __future__ import annotations

from pitchopt.plotting.comparison import (
    ExcerptLike,
    method_figures,
    plot_changes,
    plot_excerpts,
    plot_over_intensity,
)
from pitchopt.plotting.figures import (
    contraction_figure,
    learned_profiles_figure,
    learning_figure,
    loads_figure,
    png,
    profiles_figure,
    several_figures,
    simulation_figure,
    steady_curves_figure,
    tradeoff_figure,
)
from pitchopt.plotting.learning import (
    plot_contraction,
    plot_learned_profiles,
    plot_learning,
    plot_torque,
)
from pitchopt.plotting.passage import plot_loads, plot_profiles
from pitchopt.plotting.polar import plot_polar_fit
from pitchopt.plotting.sensitivity import estimates_figure, plot_design_plane, plot_estimates
from pitchopt.plotting.sensitivity_design import (
    plot_design_curve,
    plot_design_sensitivity,
    sensitivity_figure,
)
from pitchopt.plotting.several import plot_regrets, plot_several_profiles
from pitchopt.plotting.simulation import (
    SteadyCurve,
    plot_channel,
    plot_over_wind_speed,
    plot_steady_curve,
)
from pitchopt.plotting.tradeoff import plot_tradeoff
from pitchopt.plotting.tuning import (
    plot_acquisition,
    plot_design_space,
    plot_posterior,
    plot_progress,
)
from pitchopt.plotting.tuning_individual import (
    GainSamples,
    gain_samples,
    individual_pitch_figure,
    plot_cost_progress,
    plot_gain_offset,
    progress_figure,
)
from pitchopt.plotting.tuning_minimum_pitch import (
    PitchSamples,
    minimum_pitch_figure,
    pitch_tables_figure,
    plot_over_time,
    plot_pitch_samples,
    plot_pitch_tables,
)
from pitchopt.plotting.turbine_learning import (
    plot_turbine_learning,
    plot_turbine_profiles,
    turbine_learning_figure,
)
from pitchopt.plotting.wind import plot_wind_field

__all__ = [
    "ExcerptLike",
    "GainSamples",
    "PitchSamples",
    "SteadyCurve",
    "contraction_figure",
    "estimates_figure",
    "gain_samples",
    "individual_pitch_figure",
    "learned_profiles_figure",
    "learning_figure",
    "loads_figure",
    "method_figures",
    "minimum_pitch_figure",
    "pitch_tables_figure",
    "plot_acquisition",
    "plot_changes",
    "plot_channel",
    "plot_contraction",
    "plot_cost_progress",
    "plot_design_curve",
    "plot_design_plane",
    "plot_design_sensitivity",
    "plot_design_space",
    "plot_estimates",
    "plot_excerpts",
    "plot_gain_offset",
    "plot_learned_profiles",
    "plot_learning",
    "plot_loads",
    "plot_over_intensity",
    "plot_over_time",
    "plot_over_wind_speed",
    "plot_pitch_samples",
    "plot_pitch_tables",
    "plot_polar_fit",
    "plot_posterior",
    "plot_profiles",
    "plot_progress",
    "plot_regrets",
    "plot_several_profiles",
    "plot_steady_curve",
    "plot_torque",
    "plot_tradeoff",
    "plot_turbine_learning",
    "plot_turbine_profiles",
    "plot_wind_field",
    "png",
    "profiles_figure",
    "progress_figure",
    "sensitivity_figure",
    "several_figures",
    "simulation_figure",
    "steady_curves_figure",
    "tradeoff_figure",
    "turbine_learning_figure",
]
