import json

from pigbench.runs import metrics
from pigbench.runs.metrics import MetricsLog


def test_lines_are_on_the_disk_at_once(tmp_path):
    with MetricsLog(tmp_path, step=0) as log:
        log.write(10, {"loss": 0.5, "gap": float("nan")})
        assert (
            tmp_path / "metrics.jsonl"
        ).read_text() == '{"step": 10, "loss": 0.5, "gap": null}\n'


def test_taking_up_again_drops_what_lies_beyond_the_step(tmp_path):
    with MetricsLog(tmp_path, step=0) as log:
        for step in (10, 20, 30):
            log.write(step, {"loss": step})
    with open(tmp_path / "metrics.jsonl", "a") as file:
        file.write('{"step": 40, "lo')
    assert [line["step"] for line in metrics.read(tmp_path)] == [10, 20, 30]
    with MetricsLog(tmp_path, step=20) as log:
        log.write(30, {"loss": -1, "extra": 2})
    lines = [json.loads(line) for line in (tmp_path / "metrics.jsonl").read_text().splitlines()]
    assert lines == [
        {"step": 10, "loss": 10},
        {"step": 20, "loss": 20},
        {"step": 30, "loss": -1, "extra": 2},
    ]
