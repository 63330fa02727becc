"""States of cells, told from folders made by hand."""

import dataclasses

import pytest

from pigbench.evaluation import episodes
from pigbench.suite.spec import Suite
from pigbench.suite.status import CUT_OFF, DONE, status, untried

STEPS = 20_000  # of the suite's first cell


@pytest.fixture
def noisy(suite) -> Suite:
    evaluation = dataclasses.replace(suite.evaluation, noise=(5.0, 0.5))
    return dataclasses.replace(suite, evaluation=evaluation)


def test_a_cell_is_tried_in_noise_if_its_last_policy_is(noisy, make_run, tmp_path):
    cell = noisy.cells()[0]
    run = make_run(tmp_path / cell.name, {STEPS // 2: [[0]], STEPS: [[1]]})
    earlier, last = episodes.read(run.episodes_path)
    assert untried(noisy, cell, tmp_path) == [5.0, 0.5]
    episodes.record(run.noise_path(5), [earlier])  # as before the suite trained longer
    episodes.record(run.noise_path(0.5), [earlier, last])
    assert untried(noisy, cell, tmp_path) == [5.0]
    episodes.record(run.noise_path(5), [last])
    assert untried(noisy, cell, tmp_path) == []
    run.noise_path(5).write_text("step")  # torn
    assert untried(noisy, cell, tmp_path) == [5.0]


def test_a_cell_whose_episodes_are_gone_is_not_done(suite, make_run, tmp_path):
    cell = suite.cells()[0]
    run = make_run(tmp_path / cell.name, {STEPS: [[1]]})
    (run.checkpoints_path / str(STEPS)).mkdir(parents=True)
    assert status(suite, tmp_path)[0][1:] == (DONE, STEPS, 100.0)
    header, *_ = run.episodes_path.read_text().splitlines(keepends=True)
    run.episodes_path.write_text(header)
    assert status(suite, tmp_path)[0][1:] == (CUT_OFF, 0, None)
