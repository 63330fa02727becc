"""Memory against the sizes of what goes in and out."""

from pigbench import cli, envs
from pigbench.bench import footprint


def test_what_goes_in_and_out_is_counted():
    env = envs.make("cube-single")
    # qpos 21, qvel 20, warm start 20, pinch 3 and 1, force 1 in four bytes each, and two flags.
    state = 4 * (21 + 20 + 20 + 3 + 1 + 1) + 2
    for count in (1, 8):
        size = footprint.footprint(env, count)
        assert size.arguments == count * (state + 4 * env.action_size)
        assert size.results >= count * state
        assert size.total == size.arguments + size.results + size.temporary


def test_memory_is_tabled(capsys):
    cli.run(["bench", "memory", "cube-single", "--engine", "mujoco", "--simulations", "2", "4"])
    lines = [line.split("|") for line in capsys.readouterr().out.splitlines() if "mujoco" in line]
    assert [line[2].strip() for line in lines] == ["2", "4"]
