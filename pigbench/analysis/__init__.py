"""Analysis of trained value functions in free motion, in contact, and with a cube in hand."""
