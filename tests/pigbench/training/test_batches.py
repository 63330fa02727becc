"""Rows on the disk give the batches, and the parameters, that rows on the device give."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import registry
from pigbench.data import dataset, sampler
from pigbench.data.sampler import Rows
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.layout import Layout, Space
from pigbench.training import batches
from pigbench.training.updates import join, make_updates

SPACE = Space(Layout.of({"joint_pos": 6, "cube_0_pos": 3}), 5)
# To the bit, which is the emitters' doing too.
pytestmark = pytest.mark.usefixtures("users_emitters")
NETWORKS = {"value_hidden_sizes": (16,), "actor_hidden_sizes": (16,), "latent_size": 8}


@pytest.fixture
def split(tmp_path, spec, arrays):
    """30 episodes of 12 rows in ten shards, of which one lost an episode."""
    spec = dataclasses.replace(
        spec, episodes={"train": 30}, episodes_per_shard=3, rows_per_episode=12
    )
    writer = Writer(tmp_path / "data", spec)
    for part in writer.missing():
        dropped = int(part.number == 4)
        writer.write(part, arrays(spec, part, dropped=dropped), dropped=dropped)
    return dataset.load(tmp_path / "data").split("train")


def agent_of(method: str):
    config = registry._override(
        agents.get(method).config, {"batch_size": 32, **NETWORKS, "low": NETWORKS}
    )
    return agents.build(
        method,
        config,
        SPACE,
        statistics=agents.Statistics.standard(9),
    )


def trained(agent, rows, seeds, *stops):
    keys = [jax.random.split(jax.random.key(seed)) for seed in seeds]
    key = join([key for _, key in keys])
    state = join([agents.create(agent, init_key) for init_key, _ in keys])
    with batches.of(rows, agent, key) as source:
        updates = make_updates(agent, key, source)
        for start, stop in zip((0, *stops), stops, strict=False):
            state, metrics = updates(state, start, stop)
    return jax.device_get((state, metrics))


def assert_same(one, other):
    jax.tree.map(np.testing.assert_array_equal, one, other)


def test_gathered_batches_are_those_drawn_on_the_device(split, monkeypatch):
    monkeypatch.setattr(batches, "_MOST_UPDATES", 4)
    agent = agent_of("pi-h-flow-hjb-gcivl")
    key = jax.random.key(5)
    with batches.of(Rows.on_disk(split), agent, key) as source:
        for start, (part, end) in zip((6, 8, 12), source.parts(6, 13), strict=True):
            assert end == min(13, start // 4 * 4 + 4)
            for step in range(start, end):
                batch_key, _ = batches.keys_of(key, step)
                drawn = sampler.sample(
                    batch_key, Rows.from_split(split), agent.sampling, agent.config.batch_size
                )
                gathered = source.batch(part, batch_key, jnp.int32(step))
                assert_same(gathered, drawn)


@pytest.mark.parametrize("method", ["eik-gcivl", "pi-h-flow-eik-gcivl"])
def test_parameters_do_not_depend_on_where_the_rows_are(split, monkeypatch, method):
    monkeypatch.setattr(batches, "_MOST_UPDATES", 4)
    agent = agent_of(method)
    on_device = trained(agent, Rows.from_split(split), [3], 11)
    on_disk = trained(agent, Rows.on_disk(split), [3], 6, 11)
    assert_same(on_disk[0], on_device[0])


def test_seeds_together_gather_their_own_batches(split, monkeypatch):
    monkeypatch.setattr(batches, "_MOST_UPDATES", 4)
    agent = agent_of("hjb-gcivl")
    states, metrics = trained(agent, Rows.on_disk(split), [3, 4], 11)
    expected, expected_metrics = trained(agent, Rows.from_split(split), [3, 4], 11)
    assert_same(states, expected)
    jax.tree.map(
        lambda x, y: np.testing.assert_allclose(x, y, rtol=1e-5), metrics, expected_metrics
    )


def test_a_batch_that_meets_nan_names_the_file(split):
    path = split.folder / "train-00003" / "observations.npy"
    array = np.load(path)
    array[7, 2] = np.nan
    np.save(path, array)
    with pytest.raises(UserError, match=r"train-00003/observations\.npy holds NaN .*\(in row 7\)"):
        trained(agent_of("gcbc"), Rows.on_disk(split), [0], 40)
