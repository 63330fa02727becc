import contextlib
import os
import signal
import subprocess
import sys

import pytest

from pigbench.suite import runner
from pigbench.suite.jobs import Job
from pigbench.support import files
from pigbench.support.lock import only_writer


def test_a_job_waits_until_no_other_process_writes_its_folder(tmp_path):
    jobs = [Job(name, tmp_path / name, ("list", "envs")) for name in ("held", "free")]
    logs = {job.name: tmp_path / f"{job.name}.log" for job in jobs}
    seen = []
    with contextlib.ExitStack() as other:
        other.enter_context(only_writer(tmp_path / "held"))

        def report(names):
            seen.append((names, logs["held"].exists()))
            if names == ("held",):  # the free one has ended
                other.close()

        ended = runner.run(jobs, workers=1, log=logs.__getitem__, report=report)
    assert list(ended.items()) == [("free", 0), ("held", 0)]
    assert seen[0] == (("free", "held"), False)
    assert all("cube-single" in log.read_text() for log in logs.values())


def test_a_job_waits_until_the_one_that_it_is_after_has_ended(tmp_path):
    first = Job("first", tmp_path / "first", ("list", "envs"))
    second = Job("second", tmp_path / "second", ("list", "envs"), after="first")
    seen = []
    with contextlib.ExitStack() as other:
        other.enter_context(only_writer(first.folder))

        def report(names):
            seen.append(names)
            other.close()

        ended = runner.run(
            [first, second], workers=2, log=lambda name: tmp_path / f"{name}.log", report=report
        )
    assert list(ended.items()) == [("first", 0), ("second", 0)]
    assert seen[:2] == [("first",), ("first",)]  # held, and running
    assert ("first", "second") not in seen


def test_a_job_that_another_process_is_in_the_way_of_is_run_again(data, tmp_path):
    job, log = Job("card", tmp_path / "card", ("data", "card", str(data))), tmp_path / "card.log"
    with contextlib.ExitStack() as other:
        other.enter_context(files.replacing_file(data / "README.md"))

        def report(_):
            if log.exists() and "is being written by another process" in log.read_text():
                other.close()

        assert runner.run([job], workers=1, log=lambda _: log, report=report) == {"card": 0}
    refused, done = log.read_text().splitlines()
    assert refused.startswith("pigbench: ")
    assert done.endswith("is written")


def test_jobs_know_how_many_share_the_machine(tmp_path):
    """A plugin is a way to ask a job."""
    plugin = tmp_path / "told.py"
    plugin.write_text("import os\nprint(os.environ['PIGBENCH_SHARERS'], os.environ.get('NPROC'))")

    def told(workers: int, count: int) -> set[str]:
        names = [f"{workers}-{count}-{number}" for number in range(count)]
        jobs = [Job(name, tmp_path / name, ("list", "envs")) for name in names]
        runner.run(
            jobs,
            workers=workers,
            log=lambda name: tmp_path / f"{name}.log",
            options=["--plugin", str(plugin)],
        )
        return {(tmp_path / f"{name}.log").read_text().splitlines()[0] for name in names}

    assert told(1, 2) == {f"1 {os.environ.get('NPROC')}"}
    assert told(3, 2) == {f"2 {os.environ.get('NPROC', '1')}"}


def test_all_are_ended_whatever_becomes_of_one(tmp_path):
    class Stubborn(subprocess.Popen):
        def terminate(self) -> None:
            super().terminate()
            raise RuntimeError("not so")

    started = []

    def start(job, log, options):
        started.append(Stubborn([sys.executable, "-c", "import time; time.sleep(60)"]))
        return started[-1]

    def report(_):
        raise KeyboardInterrupt

    jobs = [Job(name, tmp_path / name, ()) for name in "abc"]
    with pytest.raises(RuntimeError, match="not so"):
        runner.run(jobs, workers=3, log=tmp_path.joinpath, report=report, start=start)
    assert [process.poll() for process in started] == [-signal.SIGTERM] * 3
