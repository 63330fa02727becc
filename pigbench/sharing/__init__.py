"""Sharing of policies and data sets with people who do not have pigbench."""
