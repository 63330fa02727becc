"""Every command by name, without its code."""

from collections.abc import Sequence
from typing import NamedTuple


class Command(NamedTuple):
    """The location of a command's class, imported when it is chosen, and a summary.

    A command that `resumes` continues where it was cut off when it is run again; others start over.
    """

    module: str
    kind: str
    summary: str
    resumes: bool = False


COMMANDS = {
    "list": Command("listing", "List", "list environments or methods by name"),
    "generate": Command("generate", "Generate", "collect an offline data set", resumes=True),
    "data info": Command("data", "DataInfo", "describe a data set"),
    "data verify": Command("data", "DataVerify", "find truncated or altered files of a data set"),
    "data filter": Command("data", "DataFilter", "keep a data set's good episodes", resumes=True),
    "data export": Command("data", "DataExport", "write a data set for OGBench, Minari or LeRobot"),
    "data card": Command("data", "DataCard", "write a data set's README for a hub"),
    "data push": Command(
        "data", "DataPush", "put a data set on the Hugging Face hub", resumes=True
    ),
    "data pull": Command("data", "DataPull", "fetch a data set from the hub", resumes=True),
    "data import": Command(
        "data", "DataImport", "make a data set from OGBench's files or a robot's logs", resumes=True
    ),
    "data render": Command("render", "RenderData", "draw an episode of a data set as a film"),
    "train": Command("train", "Train", "train one method, with one seed or several", resumes=True),
    "evaluate": Command("evaluate", "Evaluate", "roll out a trained policy on every task"),
    "table": Command("report", "PrintTable", "print success rates of runs as tables"),
    "suite": Command(
        "suite", "RunSuite", "train environments x methods x seeds as one job", resumes=True
    ),
    "suite status": Command("suite_status", "SuiteStatus", "show the progress of a suite"),
    "plot": Command("report", "DrawPlot", "draw curves, bars, boxes or profiles of runs"),
    "report": Command("report", "MakePage", "make a page of runs or of a suite, for any browser"),
    "export": Command("export", "Export", "write a policy to share, which acts without pigbench"),
    "render": Command(
        "render", "Render", "draw a task as a picture, or a policy's episodes as a film"
    ),
    "analyze": Command(
        "analyze", "Analyze", "measure residuals of a value function by contact mode"
    ),
    "subgoals": Command(
        "subgoals", "SubgoalErrors", "measure how well a hierarchy reaches its subgoals"
    ),
    "parity": Command("parity", "Parity", "measure how close the simulations are to OGBench's"),
    "parity data": Command("parity", "ParityData", "measure how close data are to OGBench's own"),
    "parity policy": Command(
        "parity", "ParityPolicy", "compare a policy's success here and in OGBench"
    ),
    "bench generate": Command("bench", "BenchGenerate", "time data generation beside OGBench's"),
    "bench evaluate": Command("bench", "BenchEvaluate", "time evaluation beside OGBench's"),
    "bench train": Command("bench", "BenchTrain", "time the updates of methods, side by side"),
    "bench rows": Command(
        "bench", "BenchRows", "time training from rows on the device and on the disk"
    ),
    "bench startup": Command(
        "bench", "Startup", "measure the processor time that commands take to start"
    ),
    "bench scale": Command(
        "scaling", "Scale", "time control steps by numbers of simulations and cubes"
    ),
    "bench memory": Command("scaling", "Memory", "show how much memory a control step needs"),
    "bench device": Command("device", "Device", "measure this machine's accelerator"),
    "toy": Command("toy", "Toy", "fit a known cost-to-go under each regulariser"),
}


def named(arguments: Sequence[str]) -> str | None:
    """The command named by the first two words, or else by the first; None if there is none."""
    names = (" ".join(arguments[:words]) for words in (2, 1))
    return next((name for name in names if name in COMMANDS), None)
