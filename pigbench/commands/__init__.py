"""The commands of the command line: each a frozen dataclass of arguments with a `run`.

Their modules import at the top what takes no time. Whatever imports JAX, MuJoCo or Matplotlib is
imported when a command runs, so that its help comes at once.
"""
