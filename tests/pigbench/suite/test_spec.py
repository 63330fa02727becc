from pathlib import Path

import pytest

from pigbench import agents, envs
from pigbench.errors import UserError
from pigbench.suite import spec
from pigbench.support import files

VARIANTS = """
[variants.full]
low_level_representation = "full"
[variants.weak.low.regularizer]
weight = 0.1
"""


def test_cells_are_the_product_a_seed_after_another(suite):
    names = [cell.name for cell in suite.cells()]
    assert len(names) == 2 * 2 * 2
    assert names[:3] == [
        "cube-single/gcivl/0",
        "cube-single/h-flow-gcivl/0",
        "cube-double/gcivl/0",
    ]
    assert names[4] == "cube-single/gcivl/3"


def test_variants_are_an_axis_and_add_to_the_overrides_of_all(suite, write):
    text = write().read_text()
    suite = spec.read(write(text + VARIANTS))
    cells = {cell.name: cell for cell in suite.cells()}
    assert len(cells) == 16
    overrides = suite.overrides(cells["cube-single/h-flow-gcivl+weak/3"])
    assert overrides == {"learning_rate": 1e-3, "low.regularizer.weight": 0.1}


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("preset =", "prset =", "prset: there is no such field"),
        ("steps = 20_000", "step = 20_000", r"environments.0.step: there is no such field"),
        ("seeds = [0, 3]", "", "seeds: this field is missing"),
        ("seeds = [0, 3]", "seeds = []", "seeds is empty: name at least one"),
        ("seeds = [0, 3]", "seeds = [3, 3]", "seeds names one twice: 3, 3"),
        ("seeds = [0, 3]", 'seeds = ["a"]', "seeds.0: Input should be a valid integer.*not 'a'"),
        ("seeds = [0, 3]", "seeds = [0", "is not valid TOML"),
        ('"cube-double"', '"cube-single"', "environments names one twice"),
        ("validation_episodes = 2", "validation_episodes = -5", "validation_episodes: .*not -5"),
        ('policy = "play"', "polcy = 'play'", "data.polcy: there is no such field"),
        ("[data]", "[[data]]", "data: .* is no set of fields"),
        ('policy = "play"', "episode_transitions = 0", "data.episode_transitions: .*not 0"),
        ("transitions = 1_500", "transitions = 0", r"environments\.0\.transitions: .*not 0"),
        ("steps = 20_000", "steps = 0", r"environments\.0\.steps: .*not 0"),
        ("every = 5_000", "every = 0", "evaluation.every: .*not 0"),
        ("episodes = 20", "episodes = 0", "evaluation.episodes: .*not 0"),
        ("episodes = 20", "noise = [0, -1]", r"evaluation\.noise\.1: .*not -1"),
        ("episodes = 20", "noise = [nan]", r"evaluation\.noise\.0: .*not nan"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(write, old, new, complaint):
    text = write().read_text()
    with pytest.raises(UserError, match=complaint):
        spec.read(write(text.replace(old, new)))


def test_a_kept_suite_is_the_same(suite, tmp_path):
    spec.write(tmp_path / "kept.json", suite)
    assert spec.read_kept(tmp_path / "kept.json") == suite


def test_a_kept_suite_knows_which_fields_of_its_data_were_given(suite, tmp_path):
    spec.write(tmp_path / "kept.json", suite)
    given = spec.read_kept(tmp_path / "kept.json").data.model_fields_set
    assert given == suite.data.model_fields_set == {"policy", "validation_episodes"}


def test_an_invalid_kept_suite_is_said(tmp_path):
    files.write_sealed(tmp_path / "kept.json", {"methods": []})
    with pytest.raises(UserError, match=r"kept\.json is invalid"):
        spec.read_kept(tmp_path / "kept.json")


@pytest.mark.parametrize("path", sorted(spec.READY.glob("*.toml")), ids=lambda path: path.stem)
def test_ready_suites_name_what_there_is(path):
    suite = spec.read(Path(path.stem))
    assert set(suite.methods) <= set(agents.names())
    assert {environment.name for environment in suite.environments} <= set(envs.names())


def test_an_unknown_ready_suite_lists_the_known():
    with pytest.raises(UserError, match=r"no suite is named cpu-flt: .*cpu-flat"):
        spec.read(Path("cpu-flt"))
