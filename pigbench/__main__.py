"""`python -m pigbench`: the command line."""

from pigbench.cli import main

main()
