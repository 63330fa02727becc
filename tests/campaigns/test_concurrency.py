"""Two commands on one folder at once: each does its work, or says in one line why it does not.

`make test` tries a few pairs; `PIGBENCH_CAMPAIGN=all` every one.
"""

import itertools
import os
import shutil
from pathlib import Path

from pigbench.data import dataset, ogbench
from pigbench.errors import BusyError, UserError
from pigbench.evaluation import episodes
from pigbench.support import files

SMALL = "--preset cpu --agent.batch-size 8 --agent.actor-hidden-sizes 8"
STEPS = "--steps 1 --evaluate-every 1 --evaluation.episodes 1"

COMMANDS = {
    "import": "data import F.npz --environment cube-single --out OUT",
    "generate": "generate cube-single --out OUT --episodes 2 --validation-episodes 1 "
    "--episodes-per-shard 1 --episode-length 11",
    "train": f"train gcbc --data DATA --out OUT {SMALL} {STEPS}",
    "train again": f"train gcbc --data DATA --out RUN {SMALL} {STEPS}",
    "evaluate": "evaluate RUN --episodes 1 --seed 5",
    "analyze": "analyze RUN --data DATA --samples 10",
    "table": "table RUN",
    "plot": "plot RUN --out F.png",
    "info": "data info DATA",
    "verify": "data verify OUT",
    "export": "data export DATA --out G.npz",
}
FEW = [("import", "import"), ("import", "verify"), ("table", "plot"), ("export", "export")]
PAIRS = list(itertools.combinations_with_replacement(COMMANDS, 2))
CHOSEN = PAIRS if os.environ.get("PIGBENCH_CAMPAIGN") == "all" else FEW


def test_two_at_once(server, place, subtests):
    """Each ends with 0, or with 2 or 75 and a line; what both leave behind is whole."""
    ogbench.write(dataset.load(Path("DATA")), Path("F.npz"))
    whole = place / "WHOLE"
    whole.mkdir()
    for name in ("DATA", "RUN"):
        (place / name).rename(whole / name)
    for number, pair in enumerate(CHOSEN):
        with subtests.test(msg=" and ".join(pair)):
            _restore(place, whole)
            logs = [place / f"{number}.{which}.log" for which in (0, 1)]
            commands = [COMMANDS[name] for name in pair]
            begun = [server.start(*both) for both in zip(commands, logs, strict=True)]
            statuses = [server.wait(process) for process in begun]
            said = [log.read_text() for log in logs]
            for status, text in zip(statuses, said, strict=True):
                complaints = [line for line in text.splitlines() if line.startswith("pigbench: ")]
                assert "Traceback" not in text, text
                assert status in (0, UserError.status, BusyError.status), text
                assert len(complaints) == (status != 0), text
            assert 0 in statuses or set(pair) <= {"analyze", "verify"}, said
            assert dataset.verify(Path("DATA")) == []
            assert episodes.read(Path("RUN/episodes.csv"))
            if (place / "OUT/manifest.json").exists():
                assert dataset.verify(Path("OUT")) == []


def _restore(place: Path, whole: Path) -> None:
    """DATA and RUN as they were, and no OUT."""
    for name in ("DATA", "RUN", "OUT"):
        files.remove_folder(place / name)
    for name in ("DATA", "RUN"):
        shutil.copytree(whole / name, place / name)
