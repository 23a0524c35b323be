"""
Wind over the rotor disc
========================

x
"""

from example_figures import example
