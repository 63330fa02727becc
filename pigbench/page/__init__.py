"""One page of what runs achieved, with all that is needed to trust and repeat it."""
