"""Handing on what was made here: policies and data sets, for people who have no pigbench."""
