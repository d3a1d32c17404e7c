"""The Python module against the program: a study of the lab rig, tables, answers, histories, errors."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import bladeoff
import pytest

STUDY = """schema = 1
name = "small"
machine = "lab_rig.toml"

[set]
"run.end_time" = "0.04 s"

[[vary]]
path = "contact.gap"
values = ["0.4 mm", "1 mm"]

[design]
kind = "monte-carlo"
samples = 3

[[uncertain]]
path = "blade_off.phase"
as = "release_angle"
distribution = "periodic"
lower = "0 deg"
upper = "360 deg"

[[question]]
name = "load"
mean = "max_bearing_load_N"
"""

MACHINE = bladeoff.studies() / "machines/lab_rig.toml"


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> bladeoff.Result:
    folder = tmp_path_factory.mktemp("study")
    study = folder / "small.toml"
    study.write_text(STUDY)
    (folder / "lab_rig.toml").write_text(MACHINE.read_text())
    found = bladeoff.run(study, folder / "out", workers=2)
    assert found.exit_code == 0 and found.status()["done"] == 6
    return found


def test_tables_have_rows_units_and_meanings(result: bladeoff.Result) -> None:
    table = result.read()
    assert table["sample"].to_list() == list(range(6))
    assert set(table["diaphragms.seal.contact.gap_m"].to_list()) == {0.0004, 0.001}
    columns = bladeoff.columns(result)
    assert columns["max_bearing_load_N"].unit == "N" and "bearing" in columns["max_bearing_load_N"].meaning
    assert columns["status"].unit == "" and list(columns) == table.columns
    frame = result.read("pandas")
    assert frame["max_bearing_load_N"].tolist() == table["max_bearing_load_N"].to_list()
    assert frame.attrs["units"]["release_angle_rad"] == "rad"
    with pytest.raises(ValueError, match="allowed: 'polars', 'pandas'"):
        bladeoff.read(result, "arrow")  # type: ignore[call-overload]


def test_answers_are_those_of_the_file(result: bladeoff.Result) -> None:
    answers = result.answers()
    assert answers["complete"] and [one["name"] for one in answers["answers"]] == ["load", "load"]
    written = json.loads(Path(result.directory, "answers.json").read_text())
    assert answers == written
    rows = zip(*(result.read()[name].to_list() for name in ("diaphragms.seal.contact.gap_m", "max_bearing_load_N")))
    loads = [load for gap, load in rows if gap == 0.0004]
    assert len(loads) == 3 and answers["answers"][0]["estimate"] == pytest.approx(sum(loads) / 3, rel=1e-12)


def test_a_history_is_that_of_its_sample(result: bladeoff.Result) -> None:
    history = result.history(2)
    assert history["time_s"].is_sorted() and history["time_s"][-1] == pytest.approx(0.04, rel=0.01)
    assert "rotor.speed_rad_s" in history.columns
    frame = bladeoff.history(result, 2, "pandas")
    assert len(frame) == len(history) and frame.attrs["units"]["rotor.speed_rad_s"] == "rad/s"
    with pytest.raises(bladeoff.BladeoffError, match="has no sample 6"):
        result.history(6)


def test_a_transient_has_its_parameters_by_path_or_keyword() -> None:
    by_path = bladeoff.simulate(MACHINE, {"contact.gap": "0.5 mm", "run.end_time": 0.02})
    by_keyword = bladeoff.simulate(MACHINE, contact__gap=0.0005, run__end_time="20 ms")
    assert by_path == by_keyword and by_path["status"] == "ok" and by_path["end_time_s"] == pytest.approx(0.02, rel=0.01)


class Numpy64(float):
    """A float whose repr is no number, as that of numpy.float64."""

    def __repr__(self) -> str:
        return f"np.float64({float(self)})"


def test_floats_of_numpy_are_numbers() -> None:
    ours = bladeoff.simulate(MACHINE, {"contact.friction": Numpy64(0.2), "run.end_time": "20 ms"})
    assert ours == bladeoff.simulate(MACHINE, {"contact.friction": 0.2, "run.end_time": "20 ms"})


def test_ctrl_c_ends_a_study_in_order(tmp_path: Path) -> None:
    study = tmp_path / "long.toml"
    study.write_text(STUDY.replace("samples = 3", "samples = 100000"))
    (tmp_path / "lab_rig.toml").write_text(MACHINE.read_text())
    script = f"import bladeoff; bladeoff.run({str(study)!r}, {str(tmp_path / 'out')!r}, workers=1)"
    running = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120
    while not (tmp_path / "out/status.json").is_file() or bladeoff.status(tmp_path / "out")["done"] == 0:
        assert running.poll() is None and time.monotonic() < deadline
        time.sleep(0.1)
    running.send_signal(signal.SIGINT)
    _, told = running.communicate(timeout=120)
    assert "KeyboardInterrupt" in told
    state = bladeoff.status(tmp_path / "out")
    assert state["state"] == "ended" and 0 < state["done"] < 200000


def test_errors_have_the_message_and_the_exit_code(tmp_path: Path) -> None:
    with pytest.raises(bladeoff.BladeoffError, match="contact.gap") as caught:
        bladeoff.simulate(MACHINE, {"contact.gap": "5 kg"})
    assert caught.value.exit_code == 3 and "simulate" in caught.value.command
    with pytest.raises(bladeoff.BladeoffError) as missing:
        bladeoff.run(tmp_path / "missing.toml")
    assert missing.value.exit_code == 3
    with pytest.raises(FileNotFoundError, match="neither results.parquet"):
        bladeoff.read(tmp_path)
