from pathlib import Path

from pigbench import cli
from pigbench.agents import HJBRegularizer
from pigbench.suite import jobs, spec

OUT = Path("out")


def test_data_is_generated_in_whole_episodes(suite):
    single, double = suite.environments
    (job,) = jobs.preparation(suite, single, OUT)
    command = cli.parse(job.arguments)
    assert (command.environment, command.out) == ("cube-single", OUT / "data/cube-single")
    assert (command.episodes, command.validation_episodes) == (2, 2)  # 1,000 transitions each
    assert command.episode_length == 1001
    (job,) = jobs.preparation(suite, double, OUT)
    command = cli.parse(job.arguments)
    assert (command.out, command.episodes) == (Path("elsewhere/double"), 100)
    assert not command.compact
    large = spec.read(Path("paper-flat"))
    (job,) = jobs.preparation(large, large.environments[0], OUT)
    assert cli.parse(job.arguments).compact


def test_data_is_filtered_if_the_suite_says_so():
    suite = spec.read(Path("real-robot"))
    collect, keep = jobs.preparation(suite, suite.environments[0], OUT)
    command = cli.parse(collect.arguments)
    assert (command.policy, command.episodes, command.out) == ("replan", 371, collect.folder)
    assert command.episode_length is None  # it ends its episodes itself
    command = cli.parse(keep.arguments)
    assert (command.folder, command.out) == (collect.folder, OUT / "data/cube-centre")
    assert keep.after == collect.name != keep.name == jobs.data_job(suite.environments[0])


def test_trained_cells_are_tried_in_noise():
    suite = spec.read(Path("real-robot"))
    job = jobs.noise(suite, suite.cells()[0], OUT, (5, 0.5))
    command = cli.parse(job.arguments)
    assert command.run_folder == OUT / "cube-centre/gcivl/0"
    assert (command.noise, command.episodes) == ((5, 0.5), 50)


def test_a_cell_is_trained_as_the_suite_says(suite):
    cells = {cell.name: cell for cell in suite.cells()}
    job = jobs.training(suite, cells["cube-double/h-flow-gcivl/3"], OUT)
    command = cli.parse(job.arguments)
    assert (command.method, command.seed, command.steps) == ("h-flow-gcivl", 3, 40_000)
    assert command.data == Path("elsewhere/double")
    assert command.out == OUT / "cube-double/h-flow-gcivl/3"
    assert (command.preset, command.agent.batch_size) == ("cpu", 256)
    assert (command.rows, command.keep, command.logger) == ("auto", "last", ("tensorboard",))
    assert not command.films
    assert (command.evaluate_every, command.evaluation.episodes) == (5_000, 20)
    assert command.agent.learning_rate == 1e-3


def test_a_suite_may_ask_for_films(write):
    suite = spec.read(write(f"films = true\n{write().read_text()}"))
    assert cli.parse(jobs.training(suite, suite.cells()[0], OUT).arguments).films


def test_overrides_of_every_kind_reach_the_configuration(write):
    variant = (
        "[variants.odd]\n"
        "layer_norm = false\n"
        'goals = "cubes"\n'
        "actor_hidden_sizes = [8, 4]\n"
        'low_level_representation = "proprio"\n'
        'low = {regularizer = {kind = "hjb", weight = 0.5}, layer_norm = true}\n'
    )
    text = write().read_text().replace('"gcivl", ', "")
    suite = spec.read(write(text + variant))
    command = cli.parse(jobs.training(suite, suite.cells()[0], OUT).arguments)
    assert command.variant == "odd"
    assert command.agent.actor_hidden_sizes == (8, 4)
    assert command.agent.low_level_representation == "proprio"
    assert not command.agent.layer_norm
    assert command.agent.goals == "cubes"
    assert command.agent.low.layer_norm
    assert command.agent.low.regularizer == HJBRegularizer(weight=0.5)
