"""Evaluation after evaluation, as a long training does: none hangs, and none keeps memory.

`make test` makes 4; `PIGBENCH_CAMPAIGN=all` 200.
"""

import faulthandler
import re
import sys
from pathlib import Path

from pigbench.evaluation.rollouts import make_evaluator
from pigbench.evaluation.settings import Evaluation
from pigbench.runs.restore import restore

PATIENCE_SECONDS = 600
MOST_GROWTH = 0.02


def resident() -> int:
    """Bytes of memory that this process keeps, without pages of files."""
    status = Path("/proc/self/status").read_text()
    (kilobytes,) = re.findall(r"RssAnon:\s+(\d+) kB", status)
    return int(kilobytes) * 1024


def test_memory_stays_the_same(prepared, whole_campaign, capsys):
    _, env, agent, state = restore(prepared / "RUN")
    evaluate = make_evaluator(env, agent, Evaluation(episodes=1))
    count = 200 if whole_campaign else 4
    kept = []
    for _ in range(count):
        faulthandler.dump_traceback_later(PATIENCE_SECONDS, exit=True, file=sys.__stderr__)
        evaluate(state.params, lambda _: None)
        faulthandler.cancel_dump_traceback_later()
        kept.append(resident())
    with capsys.disabled():
        print(f"{kept[0] / 1e6:.1f} MB after 1 evaluation, {kept[-1] / 1e6:.1f} after {count}")
    assert kept[-1] < kept[1] * (1 + MOST_GROWTH)
