"""
Figure 2: Bayesian optimisation step by step
============================================

Posterior, samples and acquisition on Forrester's function in 20 evaluations.  Run in full while
the site is built (``examples/19_bayesian_steps.py``).
"""

from example_figures import example

from pitchopt.tuning.known_functions import branin, forrester

draw = example("19_bayesian_steps")
figure, best = draw.steps(forrester(), (3, 7, 10, 20), 20)
print(f"{best.cost:.4f} at {best.x[0]:.4f}; the minimum is {forrester().minimum:.4f}")

# %%
# The same in two dimensions (not in the paper): Branin's function and its uncertainty.

surface, lowest = draw.design_space(branin(), 30)
print(f"least of the surface {lowest.mean:.4f}, deviation {lowest.std:.4f}")
