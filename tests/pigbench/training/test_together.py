import dataclasses

import pytest

from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.training.together import common_step


@pytest.mark.parametrize(
    ("saved", "step"),
    [
        (((), ()), None),
        (((0,), ()), None),  # killed in between
        (((0, 100), (0, 100, 200)), 100),
        (((100, 200), (), (0,)), "--seeds 1 2"),  # the first is trained already
        (((100, 150), (), (0, 50)), "--seeds 0 and --seeds 1 and --seeds 2"),
    ],
)
def test_runs_go_on_together_from_a_step_that_all_have(tmp_path, config, saved, step):
    together = []
    for seed, steps in enumerate(saved):
        run = runs.Run(tmp_path / str(seed), dataclasses.replace(config, seed=seed))
        run.checkpoints_path.mkdir(parents=True)
        for one in steps:
            (run.checkpoints_path / str(one)).mkdir()
        (run.checkpoints_path / "300.orbax-checkpoint-tmp").mkdir()
        assert run.is_trained == (200 in steps)
        together.append(run)
    if isinstance(step, str):
        with pytest.raises(UserError, match=f"to go on from together: ask for {step}$"):
            common_step(together)
    else:
        assert common_step(together) == step
