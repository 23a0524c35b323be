"""Tower of a wind turbine designed together with its controller."""
