"""Post-optimum sensitivity: what a change of a frozen parameter does to an optimal value."""
