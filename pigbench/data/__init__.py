"""Offline data sets: their format, how they are collected, and batches drawn from them."""
