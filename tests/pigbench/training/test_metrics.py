import json

import numpy as np
from tensorboardX.proto.event_pb2 import Event

from pigbench.training import metrics
from pigbench.training.metrics import MetricsLog


def test_lines_are_on_the_disk_at_once(tmp_path):
    with MetricsLog(tmp_path, step=0) as log:
        log.write(10, {"loss": np.float32(0.5), "gap": float("nan")})
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


def test_tensorboard_events_hold_the_same_and_the_purge(tmp_path):
    with MetricsLog(tmp_path, step=20) as log:
        log.write(30, {"loss": 0.25})
    (path,) = (tmp_path / "tensorboard").iterdir()
    content, events = path.read_bytes(), []
    while content:
        # TFRecord: length (8 bytes), its checksum (4), the event, its checksum (4).
        length = int.from_bytes(content[:8], "little")
        events.append(Event.FromString(content[12 : 12 + length]))
        content = content[16 + length :]
    scalars = [(e.step, v.tag, v.simple_value) for e in events for v in e.summary.value]
    assert scalars == [(30, "loss", 0.25)]
    assert 21 in [event.step for event in events if event.HasField("session_log")]
