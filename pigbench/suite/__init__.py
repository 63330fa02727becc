"""Suites: many training runs as one job, environments by methods by seeds."""
