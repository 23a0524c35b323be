"""Controllers: generator torque, collective and individual pitch. Numbers and matrices only."""
