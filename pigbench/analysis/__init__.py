"""What trained value functions look like in free motion, in touch, and with a cube in hand."""
