"""
Figure 2: wind over the rotor disc
==================================

Wind speed that a blade meets over azimuth and radius: shear, and the tower's shadow below the hub.
Computed while the site is built (``examples/01_wind_field.py``).  The paper's colours run from 13
to 16 m/s as well; its tower shadow has a pole that ours has not (:doc:`/papers`).
"""

from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.plotting import plot_wind_field
from windfield import sample_disc

case = load_case("biegel2011")
rotor = case.rotor()
disc = sample_disc(
    case.wind_field(), rotor.radius, x=-rotor.overhang, rings=80, azimuths=240, closed=True
)
figure = Figure(figsize=(6.0, 4.8), layout="constrained")
plot_wind_field(disc, ax=figure.add_subplot())
print(f"from {disc.speed.min():.2f} to {disc.speed.max():.2f} m/s")
