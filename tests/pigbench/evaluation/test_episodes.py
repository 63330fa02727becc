import os
import zlib

import pytest

from pigbench.errors import UserError
from pigbench.evaluation import episodes, measures
from pigbench.evaluation.episodes import Episode
from pigbench.evaluation.measures import Measure


def episode(step, task, number, success=False):
    known = {
        "nearest": 0.0125,
        "touched": True,
        "held": True,
        "lifted": success,
        "within_10cm": success,
        "within_5cm": success,
        "success": success,
        "within_3cm": False,
        "final_distance": 0.0375,
        "length": 120,
        "diverged": not success,
    }
    if not success:
        del known["final_distance"]
    return Episode(step, task, f"task{task}, lift", number, 7, "mujoco", known)


# The rows of the next test, as their checksums see them: without quotes.
FIRST = b"100,1,task1, lift,0,7,mujoco,0.0125,1,1,1,1,1,1,0,0.0375,120,0"
SECOND = b"100,2,task2, lift,0,7,mujoco,0.0125,1,1,0,0,0,0,0,,120,1"


def test_the_file_is_plain_csv(tmp_path):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 2, 0), episode(100, 1, 0, success=True)])
    assert path.read_text() == (
        "step,task,task_name,episode,seed,engine,nearest,touched,held,lifted,within_10cm,"
        "within_5cm,success,within_3cm,final_distance,length,diverged,check\n"
        '100,1,"task1, lift",0,7,mujoco,0.0125,1,1,1,1,1,1,0,0.0375,120,0,'
        f"{zlib.crc32(FIRST):08x}\n"
        '100,2,"task2, lift",0,7,mujoco,0.0125,1,1,0,0,0,0,0,,120,1,'
        f"{zlib.crc32(SECOND):08x}\n"
    )


def test_what_was_not_measured_yet_is_not_known(tmp_path, monkeypatch):
    """As where a file of one's own adds a measure to those of a run that has begun."""
    path = tmp_path / "episodes.csv"
    before, after = episode(100, 1, 0), episode(200, 1, 0)
    episodes.record(path, [before])
    monkeypatch.setitem(measures._MEASURES, "force", Measure("force", "force (N)", max, kind=float))
    assert episodes.read(path) == [before]
    after = after._replace(measures={**after.measures, "force": 2.5})
    episodes.record(path, [after])
    assert path.read_text().splitlines()[0].endswith(",diverged,force,check")
    assert episodes.read(path) == [before, after]


def test_round_trip_in_order(tmp_path):
    path = tmp_path / "episodes.csv"
    later = [episode(200, 1, number) for number in range(3)]
    earlier = [episode(100, 1, number) for number in range(3)]
    episodes.record(path, later)
    episodes.record(path, earlier)
    assert episodes.read(path) == earlier + later


def test_repeating_an_evaluation_replaces_it(tmp_path):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 1, number) for number in range(3)])
    episodes.record(path, [episode(200, 1, 0)])
    episodes.record(path, [episode(100, 1, 0, success=True)])
    assert episodes.read(path) == [episode(100, 1, 0, success=True), episode(200, 1, 0)]


def test_the_best_step_is_the_first_with_the_most_success():
    def rows(step, *successes):
        return [episode(step, 1, number, bool(won)) for number, won in enumerate(successes)]

    several = [*rows(300, 1, 0, 1, 0), *rows(200, 1, 0), *rows(100, 0, 0), *rows(400, 0, 1, 0)]
    assert episodes.best_step(several) == 200


@pytest.mark.parametrize("cut", [1, 9, 60, 120])
def test_a_cut_file_is_named(tmp_path, cut):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 1, number) for number in range(3)])
    os.truncate(path, path.stat().st_size - cut)
    with pytest.raises(UserError, match=r"episodes\.csv is torn"):
        episodes.read(path)


@pytest.mark.parametrize(
    "row",
    [
        "100,1,a,0,7,e,,,,,,,1,,,120",
        "x,1,a,0,7,e,,,,,,,1,,,120,0",
        "100,1,a,0,7,e,,,,,,,2,,,120,0",
        "100,1,a,0,7,e,,,,,,,1,,,120,0,9",
        "100,1,a,0,7,e,x,,,,,,1,,,120,0",
        "100,1,a,0,7,e,,,,,,,,,,120,0",
        ",1,a,0,7,e,,,,,,,1,,,120,0",
    ],
)
def test_a_bad_row_is_named_by_its_line(tmp_path, row):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 1, 0)])
    header = path.read_text().splitlines()[0]
    path.write_text(f"{header}\n{row},{zlib.crc32(row.encode()):08x}\n")
    with pytest.raises(UserError, match="line 2 is not an episode"):
        episodes.read(path)


def test_an_altered_row_is_named_by_its_line(tmp_path):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 1, 0), episode(100, 1, 1)])
    text = path.read_text()
    for altered in (text.replace(",1,7,", ",3,7,"), f"{text}{text.splitlines()[1]},\n"):
        path.write_text(altered)
        with pytest.raises(
            UserError, match=r"is altered: the checksum of line [34] does not match"
        ):
            episodes.read(path)


def test_a_file_without_episodes_is_torn(tmp_path):
    path = tmp_path / "episodes.csv"
    episodes.record(path, [episode(100, 1, 0)])
    path.write_text(path.read_text().splitlines(keepends=True)[0])
    with pytest.raises(UserError, match=r"episodes\.csv is torn: it holds no episode"):
        episodes.read(path)


def test_only_the_wanted_steps_are_kept_and_no_file_without_any(tmp_path):
    path = tmp_path / "episodes.csv"
    episodes.keep(path, lambda step: True)
    episodes.record(path, [episode(100, 1, 0), episode(200, 1, 0)])
    episodes.keep(path, lambda step: step > 100)
    assert episodes.read(path) == [episode(200, 1, 0)]
    episodes.keep(path, lambda step: step > 200)
    assert not path.exists()


def test_other_files_are_not_episodes(tmp_path):
    path = tmp_path / "episodes.csv"
    which = "step,task,task_name,episode,seed,engine"
    unchecked, unmeasured = f"{which},success\n", f"{which},length,check\n"
    for text in ("", "\n", "a,b\n1,2\n", unchecked, unmeasured, f"{which},success,mood,check\n"):
        path.write_text(text)
        with pytest.raises(UserError, match="its columns are not step,task,task_name"):
            episodes.read(path)
    with pytest.raises(UserError, match="does not exist"):
        episodes.read(tmp_path / "missing.csv")
