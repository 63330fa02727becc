import io

from pigbench.support.progress import Progress


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_plain_lines_come_every_few_seconds():
    stream, clock = io.StringIO(), Clock()
    with Progress("train", total=2000, unit="steps", stream=stream, clock=clock) as progress:
        for _ in range(10):
            clock.now += 1.0
            progress.advance(200, note="loss 0.5")
    assert stream.getvalue() == (
        "train   0 %  0 of 2,000 steps\n"
        "train  50 %  1,000 of 2,000 steps, 200 steps/s, 0:05 left, loss 0.5\n"
        "train 100 %  2,000 of 2,000 steps, 200 steps/s, took 0:10, loss 0.5\n"
    )


def test_a_terminal_has_one_line():
    stream, clock = Terminal(), Clock()
    with Progress("train", total=10, unit="steps", stream=stream, clock=clock) as progress:
        clock.now += 0.05
        progress.advance(1)
        clock.now += 4.95
        progress.advance(4)
    text = stream.getvalue()
    assert text.count("\n") == 1
    assert [line.removesuffix("\x1b[K") for line in text.strip().split("\r")] == [
        "train   0 %  0 of 10 steps",
        "train  50 %  5 of 10 steps, 1.0 steps/s, 0:05 left",
        "train  50 %  5 of 10 steps, 1.0 steps/s, 0:05 left",
    ]


def test_work_done_earlier_counts_for_the_percentage_only():
    stream, clock = io.StringIO(), Clock()
    with Progress("make", total=100, unit="x", done=40, stream=stream, clock=clock) as progress:
        clock.now += 10.0
        progress.advance(20)
    assert stream.getvalue().splitlines() == [
        "make  40 %  40 of 100 x",
        "make  60 %  60 of 100 x, 2.0 x/s, 0:20 left",
    ]


def test_nothing_to_do_and_long_work():
    stream, clock = io.StringIO(), Clock()
    with Progress("none", total=0, unit="x", stream=stream, clock=clock):
        pass
    assert stream.getvalue() == "none 100 %  0 of 0 x\n"
    stream = io.StringIO()
    with Progress("long", total=7263, unit="x", stream=stream, clock=clock) as progress:
        clock.now += 60.0
        progress.advance(60)
    assert "2:00:03 left" in stream.getvalue()
