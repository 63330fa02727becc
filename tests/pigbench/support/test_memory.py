import pytest

from pigbench.errors import UserError
from pigbench.support import memory

UNLIMITED = 2**63 - 4096  # as version 1 says it


def test_more_simulations_than_the_memory_holds_are_refused():
    memory.require_for(10)
    with pytest.raises(UserError, match=r"1,000,000,000 simulations .* take 4,096\.0 GB at least"):
        memory.require_for(10**9)


@pytest.mark.parametrize(
    ("groups", "limits", "expected"),
    [
        ("0::/job/step", {"memory.max": "max", "job/memory.max": "5000"}, 5000),
        ("0::/job/step", {"job/step/memory.max": "4000", "job/memory.max": "5000"}, 4000),
        ("0::/job", {"other/memory.max": "10"}, None),
        ("0::/", {"memory.max": "6000"}, 6000),
        ("0::/../../elsewhere", {"memory.max": "6000"}, 6000),
        (
            "5:cpu,memory:/docker/1a\n0::/",
            {"memory/memory.limit_in_bytes": "7000", "cpu/memory.limit_in_bytes": "1"},
            7000,
        ),
        ("4:memory:/", {"memory/memory.limit_in_bytes": str(UNLIMITED)}, None),
        ("4:cpu:/", {"memory/memory.limit_in_bytes": "8000"}, None),
    ],
)
def test_a_container_has_what_its_control_groups_leave_it(tmp_path, groups, limits, expected):
    everything = memory.available(tmp_path)
    assert 1e8 < everything < 1e15
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/self/cgroup").write_text(f"{groups}\n")
    for name, text in limits.items():
        file = tmp_path / "sys/fs/cgroup" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{text}\n")
    assert memory.available(tmp_path) == (expected or everything)


def test_the_jobs_of_a_suite_have_equal_parts(monkeypatch):
    whole = memory.share()
    monkeypatch.setenv(memory.SHARERS, "4")
    assert memory.share() == whole // 4
