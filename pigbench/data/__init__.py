"""Offline data sets: their format, their collection, and the batches drawn from them."""
