"""Names that mean something to LaTeX, Markdown, Matplotlib or a file system are refused, or, where
a run has one already, are shown as they are.
"""

import dataclasses
import itertools

import numpy as np
import pytest
from PIL import Image

from pigbench import agents, cli, names
from pigbench.errors import UserError
from pigbench.suite import spec

GOOD = ["full", "lr=3e-4", "1e+3", "a_b", "two words", "v1.2", "a,b", "x" * 64]
SPECIAL = r"""\`*|<>[]{}()#$%&~^"'/:;?!@""" + "\n\t\0é±漢\u202e"
BAD = [
    *(f"a{character}b" for character in SPECIAL),
    *("", ".", "..", "a.", ".a", "-a", "_a", " a", "a ", "a--b", "a  b", "lr=$\\frac$", "x" * 65),
]


@pytest.mark.parametrize("name", GOOD)
def test_names_that_mean_themselves(name):
    assert names.check("it", name) == name


@pytest.mark.parametrize("name", BAD)
def test_other_names_are_refused(name):
    with pytest.raises(UserError, match="choose letters and digits"):
        names.check("it", name)


@pytest.mark.parametrize("name", ["a|b", "$x$", "../up"])
def test_they_are_refused_wherever_a_name_is_given(name, tmp_path):
    with pytest.raises(UserError, match="the variant is named"):
        cli.run(["train", "gcbc", "--data", "d", "--out", str(tmp_path), "--variant", name])
    with pytest.raises(UserError, match="a method is named"):
        agents.register(dataclasses.replace(agents.get("gcbc"), name=name))
    with pytest.raises(UserError, match="a variant is named"):
        spec.Suite(
            environments=(spec.Environment("cube-single", 1, 1),),
            methods=("gcbc",),
            seeds=(0,),
            evaluation=spec.EvaluationPlan(1),
            variants={name: {}},
        )


@pytest.mark.parametrize("variant", ["lr=$\\frac$", "a|b*c*", "under_$_score", "two\nlines"])
def test_runs_that_have_such_names_are_shown(variant, make_run, tmp_path, capsys):
    runs = [
        str(make_run(tmp_path / f"{seed}{number}", {1: [[1], [0]]}, seed=seed, variant=one).path)
        for seed, (number, one) in itertools.product((0, 1), enumerate((variant, "plain")))
    ]
    cli.run(["table", *runs, "--format", "markdown"])
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    columns = {row.replace(r"\|", "").count("|") for row in rows[:3]}
    assert len(columns) == 1
    for kind in ("curves", "bars", "box", "profile", "milestones"):
        picture = tmp_path / f"{kind}.png"
        cli.run(["plot", *runs, "--kind", kind, "--out", str(picture)])
        assert np.asarray(Image.open(picture)).std() > 1
