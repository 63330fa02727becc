import dataclasses

import pytest

from pigbench import agents
from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.runs.restore import agent_config
from pigbench.support import files

STATISTICS = Statistics.standard(1)


@pytest.mark.parametrize("value", [-1, 1.5, True, [], ["state"], {"kind": "x"}])
def test_a_configuration_of_other_types_is_named(tmp_path, config, value):
    of_kind = {"agent": {"regularizer": {"kind": value}}}
    for changes in ({"agent": {"goals": value}}, {"evaluation": {"engine": value}}, of_kind):
        content = dataclasses.asdict(config) | {"method": "gcivl"} | changes
        files.write_sealed(tmp_path / "config.json", content)
        with pytest.raises(UserError, match=r"config\.json (is invalid: |holds no configuration)"):
            agent_config(runs.read_run(tmp_path))


def test_the_kind_of_an_option_need_not_be_the_methods_own(tmp_path, config):
    agent = agents.GCIVLConfig(regularizer=agents.HJBRegularizer(weight=0.5, direction="raw"))
    stored = dataclasses.replace(config, method="gcivl", agent=dataclasses.asdict(agent))
    runs.open_run(tmp_path, stored, {}, STATISTICS)
    assert agent_config(runs.read_run(tmp_path)) == agent


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"target_rate": 0.005}, "target_rate: there is no such field"),
        ({"constraint": {"kind": "hjb", "speed": 2.0}}, "constraint.speed: there is no such field"),
        ({"constraint": {"kind": "hjb", "direction": "rwa"}}, "did you mean 'raw'"),
        ({"constraint": {"kind": "hbj"}}, "hbj"),
    ],
)
def test_what_a_methods_configuration_cannot_have_is_refused(tmp_path, config, changes, says):
    agent = dataclasses.asdict(agents.get("qrl").config) | changes
    runs.open_run(tmp_path, dataclasses.replace(config, method="qrl", agent=agent), {}, STATISTICS)
    with pytest.raises(UserError, match=rf"holds no configuration of 'qrl': .*{says}"):
        agent_config(runs.read_run(tmp_path))
