"""Training: updates of a method, evaluations on the way, and what they write to a run."""
