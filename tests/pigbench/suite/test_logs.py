"""What is told of jobs, by logs made by hand."""

from pigbench.suite.logs import explain, last_said, log_path
from pigbench.support.progress import Progress


def test_the_end_of_a_failed_jobs_log_is_told(tmp_path):
    log = log_path(tmp_path, "cube-single/gcbc/0")
    log.parent.mkdir(parents=True)
    log.write_text("one\ntwo\n\nthree\rfour\nexit status 2\n")
    assert explain([("cube-single/gcbc/0", 2), ("data/x", -9)], tmp_path) == (
        f"\ncube-single/gcbc/0 failed with exit status 2; the end of {log}:\n"
        "  two\n  three\n  four\n"
        f"\ndata/x failed with exit status -9; the end of {tmp_path}/logs/data/x.log:"
    )


def test_running_jobs_are_shown_by_their_last_line(tmp_path):
    log = log_path(tmp_path, "a/0")
    log.parent.mkdir(parents=True)
    with log.open("w") as stream, Progress("qrl", total=4000, unit="x", stream=stream) as progress:
        progress.advance(1000, note="resumed")
    said = "a/0: qrl  25 %  1,000 of 4,000 x; b/0: starting"
    assert last_said(tmp_path, ["a/0", "b/0"]) == said
