"""Suites: many trainings as one job, environments by methods by seeds."""
