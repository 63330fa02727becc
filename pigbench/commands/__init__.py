"""The commands of the command line: each a frozen dataclass of arguments with a `run`."""
