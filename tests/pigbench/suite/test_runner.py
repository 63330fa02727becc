import contextlib

from pigbench.suite import runner
from pigbench.suite.jobs import Job
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
