"""Measures on trajectories made by hand, and on what a scripted policy does in the simulation."""

import contextlib
import dataclasses
import runpy
from collections.abc import Iterator
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.environment import CubeEnv
from pigbench.errors import UserError
from pigbench.evaluation import episodes, folding, measures
from pigbench.evaluation.folding import FOLDINGS
from pigbench.evaluation.measures import MEASURES, Fold
from pigbench.evaluation.moment import Moment
from pigbench.evaluation.rollouts import make_evaluator
from pigbench.evaluation.settings import Evaluation
from pigbench.report import stats, tables

ROOT = Path(__file__).parents[3]

START = ((0.4, 0.0, 0.02), (0.5, 0.2, 0.02))
TARGET = ((0.4, 0.0, 0.02), (0.5, 0.0, 0.02))
AWAY = (0.4, 0.1, 0.3)


def moment(*, second=START[1], pinch=AWAY, force=0.0, success=False, diverged=False) -> Moment:
    """Two cubes, of which the first stays, at its target."""
    positions = (jnp.array(x, jnp.float32) for x in (START, (START[0], second), TARGET, pinch))
    return Moment(*positions, *map(jnp.asarray, (force, success, diverged)))


def episode(*moments: Moment, active: tuple[bool, ...] | None = None) -> dict[str, float]:
    values = folding.begin()
    for one, is_active in zip(moments, active or [True] * len(moments), strict=True):
        values = folding.advance(values, one, jnp.asarray(is_active))
    return {name: value.item() for name, value in values.items()}


def test_a_pick_and_place_step_by_step():
    over, at = (0.5, 0.2, 0.07), (0.5, 0.2, 0.03)
    taken = [
        moment(pinch=over),
        moment(pinch=(0.47, 0.2, 0.03), force=3.0),  # pushed from 3.2 cm off
        moment(pinch=at, force=20.0),
        moment(second=(0.5, 0.2, 0.039), pinch=(0.5, 0.2, 0.049), force=20.0),
        moment(second=(0.5, 0.2, 0.041), pinch=(0.5, 0.2, 0.049), force=20.0),
        moment(second=(0.5, 0.09, 0.02), pinch=AWAY),
        moment(second=(0.5, 0.045, 0.02), pinch=AWAY),
        moment(second=(0.5, 0.025, 0.02), pinch=AWAY, success=True),
    ]
    reached = [
        [name for name, value in episode(*taken[: count + 1]).items() if value is True]
        for count in range(len(taken))
    ]
    stages = ["touched", "held", "lifted", "within_10cm", "within_5cm", "success", "within_3cm"]
    assert reached == [stages[:n] for n in (0, 1, 2, 2, 3, 4, 5, 7)]
    values = episode(*taken)
    assert values["nearest"] == pytest.approx(0.008, abs=1e-6)
    assert values["final_distance"] == pytest.approx(0.025, abs=1e-6)
    assert values["length"] == 8


@pytest.mark.parametrize(
    ("one", "expected"),
    [
        (moment(pinch=(0.5, 0.2, 0.02)), set()),  # open fingers around a cube
        (moment(pinch=(0.5, 0.245, 0.02), force=5.0), set()),  # shut beside it
        (moment(pinch=(0.5, 0.219, 0.02), force=5.0), {"touched", "held"}),
        (moment(second=(0.5, 0.2, 0.06), pinch=(0.4, 0.0, 0.02), force=5.0), {"touched", "held"}),
        # One cube within 3 cm of its target, which is not all.
        (moment(second=(0.5, 0.09, 0.02)), {"within_10cm"}),
    ],
)
def test_single_moments(one, expected):
    assert {name for name, value in episode(one).items() if value is True} == expected


def test_what_follows_an_episodes_end_does_not_count():
    values = episode(
        moment(pinch=(0.5, 0.2, 0.07)),
        moment(second=TARGET[1], pinch=(0.5, 0.0, 0.02), force=9.0, success=True),
        active=(True, False),
    )
    assert values == episode(moment(pinch=(0.5, 0.2, 0.07)))


def test_of_a_diverged_episode_counts_what_it_reached():
    held = moment(pinch=START[1], force=9.0)
    values = episode(held, held._replace(diverged=jnp.asarray(True)))
    assert values["diverged"]
    assert values["held"]
    assert np.isnan(values["final_distance"])


def test_a_scripted_policy_goes_through_all_stages(scripted):
    single = envs.make("cube-single")
    env = CubeEnv(dataclasses.replace(single.spec, episode_length=120), single.physics)
    evaluate = make_evaluator(env, scripted(env.layout), Evaluation(episodes=1, seed=3))
    placed = evaluate(jnp.asarray(1.0), lambda _: None)
    for measure in MEASURES.values():
        if measure.stage:
            assert placed[measure.name].all(), measure.name
    assert placed["nearest"].max() < 0.01
    assert 0.02 < placed["final_distance"].min() <= placed["final_distance"].max() <= 0.04
    # With fingers that never close it comes as near, and no farther; they may graze the cube.
    idle = evaluate(jnp.asarray(-1.0), lambda _: None)
    assert idle["nearest"].max() < 0.02
    for name in ("held", "lifted", "within_10cm", "success"):
        assert not idle[name].any(), name
    assert idle["final_distance"].min() > 0.1
    assert (idle["length"] == 120).all()


def test_what_nobody_moves_ends_where_it_began(scripted, short):
    class Still(scripted):
        def act(self, params, observation, goal, key):
            return jnp.zeros(env.action_size)

    env = envs.make("cube-single")
    evaluate = make_evaluator(env, Still(env.layout), Evaluation(episodes=1, seed=3))
    still = evaluate(jnp.zeros(()), lambda _: None)
    far = np.linalg.norm(env._goal - env._start, axis=-1)
    np.testing.assert_allclose(still["final_distance"], far, atol=0.0142)  # of the jitter
    assert not still["touched"].any()
    assert (still["length"] == env.episode_length).all()


def test_every_fold_is_computed():
    assert set(FOLDINGS) == set(Fold)


@contextlib.contextmanager
def grip() -> Iterator[None]:
    """The measures of the documentation's example are known."""
    before = set(MEASURES)
    runpy.run_path(str(ROOT / "examples" / "grip.py"))
    try:
        yield
    finally:
        for name in set(MEASURES) - before:
            del measures._MEASURES[name]


def test_the_documentations_measures_reach_the_table(tmp_path, make_run):
    assert '--8<-- "examples/grip.py"' in (ROOT / "docs" / "extending.md").read_text()
    at = START[1]
    with grip():
        values = episode(
            moment(force=7.0),  # of the fingers on each other
            moment(pinch=at, force=2.0),
            moment(pinch=at),
            moment(pinch=at, force=5.5),
            moment(pinch=at, force=3.0),
        )
        assert (values["peak_force"], values["held_steps"]) == (7.0, 3)
        run = make_run(tmp_path / "run", {0: [[0, 0]]}, more=values)
        table = tables.milestone_table(stats.read_results([run]))
        shown = {column: table.estimates[table.rows[0], column].value for column in table.columns}
        assert (shown["peak force"], shown["held (steps)"]) == (7.0, 3.0)
        with pytest.raises(UserError, match="'peak_force' is already registered"):
            runpy.run_path(str(ROOT / "examples" / "grip.py"))
    with pytest.raises(UserError, match=r"its columns are not .*, add --plugin FILE"):
        episodes.read(run.episodes_path)


def test_a_measure_cannot_have_the_name_of_another_column(tmp_path, make_run, monkeypatch):
    monkeypatch.setitem(measures._MEASURES, "seed", MEASURES["held"])
    with pytest.raises(UserError, match="measure 'seed' has the name of another column"):
        make_run(tmp_path / "run", {0: [[0]]})
