"""Sensitivity estimates beside re-solved truth: quadratic programs and pitch designs."""
