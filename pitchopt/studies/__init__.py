"""Studies: compositions of the parts below, one sub-package each.

`learning` makes the static rotor a plant for `ilc` and computes what a learning run is compared
with.  `simulation` runs the dynamic turbine over wind speeds and seeds.
"""
