"""Dynamic turbine: structure, aerodynamics and control marched through time."""
