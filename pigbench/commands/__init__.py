"""The command line's commands: a frozen dataclass of arguments each, with a `run`."""
