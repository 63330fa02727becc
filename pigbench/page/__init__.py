"""A page of the results of runs, with all that is needed to trust and repeat them."""
