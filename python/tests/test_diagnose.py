"""The five lines, and that they are the command's."""

import html
import json
import os
import pickle
import signal
import threading
import time
import warnings

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import lacuna


@pytest.fixture(scope="module")
def found(case):
    model = lacuna.Model.from_toml(case.model)
    return lacuna.diagnose(model, [lacuna.Recording(run) for run in case.runs])


def frames(case):
    # Some versions of pandas read numbers by default as exactly as they can in a hurry.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return [pd.read_csv(run, float_precision="round_trip") for run in case.runs]


def test_the_findings_are_the_commands_to_the_last_digit(case, found):
    assert found.to_json() == case.json()
    assert found.to_dict() == json.loads(case.json())
    assert repr(found) in case.said.stdout


def test_findings_have_attributes(found):
    assert found.verdict == "missing_physics"
    (finding,) = found.findings
    assert finding.effect == finding.law and finding.channel == "theta"
    assert 0.5 < finding.probability <= 1.0
    for estimate in finding.parameters.values():
        assert estimate.std > 0.0 and estimate.unit and not estimate.at_bound
    assert all(rival.probability <= finding.probability for rival in finding.rivals)
    assert finding.law in repr(finding)


def test_the_augmented_model_is_the_commands_and_is_a_model(case, found):
    assert found.augmented.to_toml() == (case.found / "augmented.toml").read_text(encoding="utf-8")
    assert [effect for effect, _ in found.augmented.effects] == [f.law for f in found.findings]
    before = found.augmented.simulate(case.runs[0], horizon=1.0).channels["theta"]["rmse"]
    assert before < lacuna.simulate(case.model, case.runs[0], horizon=1.0).channels["theta"]["rmse"]


def test_files_are_those_of_the_command(case, found, tmp_path):
    found.save(tmp_path / "out", figures=True)
    names = {path.name for path in case.found.iterdir()}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names | {"figures"}
    for name in ("diagnosis.json", "augmented.toml"):
        assert (tmp_path / "out" / name).read_bytes() == (case.found / name).read_bytes()
    found.report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and f"lacuna.diagnose('{case.model}'" in html.unescape(page)
    framed = html.unescape(found._repr_html_())
    assert framed.startswith('<iframe srcdoc="<!DOCTYPE html>')
    # Its links lead within it, not to the notebook around it.
    assert 'href="#proof"' in framed and '<head><base href="about:srcdoc">' in framed


@pytest.mark.parametrize("kind", ["pandas", "polars", "pyarrow", "dict"])
def test_all_kinds_of_tables_are_the_same_recording(case, found, kind):
    of = {
        "pandas": lambda f: f.assign(label="a"),
        "polars": pl.from_pandas,
        "pyarrow": pa.Table.from_pandas,
        "dict": lambda f: {name: f[name].to_numpy() for name in f.columns},
    }[kind]
    runs = [lacuna.Recording(of(f), name=path.name) for f, path in zip(frames(case), case.runs)]
    if kind == "dict":
        assert lacuna.diagnose(case.model, runs).to_json() == found.to_json()
    one, own = lacuna.check(case.model, runs), lacuna.check(case.model, case.runs)
    assert one.to_dict() == own.to_dict()


def test_units_of_columns_are_brought_to_the_models(case):
    frame = frames(case)[0]
    turned = frame.assign(theta=np.degrees(frame["theta"]), t=1e3 * frame["t"]).rename(columns={"t": "ms"})
    run = lacuna.Recording(turned, time="ms", units={"theta": "deg", "ms": "ms"}, name="run")
    (channel,) = lacuna.check(case.model, run).to_dict()["channels"]
    (own,) = lacuna.check(case.model, lacuna.Recording(frame, name="run")).to_dict()["channels"]
    assert channel["range"] == pytest.approx(own["range"], rel=1e-12)
    with pytest.raises(lacuna.LacunaError, match="no column 'phi'"):
        lacuna.check(case.model, lacuna.Recording(frame, units={"phi": "deg"}))
    with pytest.raises(lacuna.LacunaError, match="column 'theta'"):
        lacuna.check(case.model, lacuna.Recording(frame, units={"theta": "kg"}))


def test_parts_of_files_are_recordings(case):
    part = lacuna.Recording(f"{case.runs[0]}#t=1..4")
    assert part.name == f"{case.runs[0].name}#t=1..4"
    (run,) = lacuna.check(case.model, part).to_dict()["recordings"]
    assert (run["from_s"], run["rows"]) == (1.0, 600)


def test_options_are_the_commands(case, command, tmp_path, found):
    (first,) = found.findings
    asked = ["--only", first.law, "dead_zone", "--exclude", "dead_zone@tau", "--exact", "tau"]
    asked += ["--learn-remainder", "--held-out", case.runs[3], "--out", tmp_path]
    said = command("diagnose", case.model, *case.runs[:3], *asked)
    assert said.returncode == 0, said.stderr
    other = lacuna.diagnose(
        case.model,
        case.runs[:3],
        case.runs[3:],
        only=[first.law, "dead_zone"],
        exclude="dead_zone@tau",
        exact="tau",
        learn_remainder=True,
    )
    assert other.to_json() == (tmp_path / "diagnosis.json").read_text(encoding="utf-8")


def test_errors_have_the_commands_words(case, command, tmp_path):
    broken = tmp_path / "model.toml"
    broken.write_text(case.model.read_text().replace("sin(theta)", "sin(thet)"))
    for arguments, call in [
        ((broken, case.runs[0]), lambda: lacuna.Model.from_toml(broken)),
        (("none.toml", case.runs[0]), lambda: lacuna.Model.from_toml("none.toml")),
        ((case.model, "none.csv"), lambda: lacuna.diagnose(case.model, "none.csv")),
        (
            (case.model, *case.runs, "--only", "coulomb_fricton"),
            lambda: lacuna.diagnose(case.model, case.runs, only=["coulomb_fricton"]),
        ),
    ]:
        said = command("diagnose", *arguments).stderr
        with pytest.raises(lacuna.LacunaError) as raised:
            call()
        assert said == f"lacuna: {raised.value}\n"
    assert issubclass(lacuna.LacunaError, ValueError)


def test_tables_that_are_none_are_refused(case):
    time = np.arange(200) * 0.01
    for data, words in [
        (3, "a recording is a path"),
        ({"t": time, "theta": time[:-1]}, "column 'theta' has 199 values, time has 200"),
        ({"t": time, "theta": ["a"] * 200}, "column 'theta': expected numbers"),
        ({"t": 0 * time, "theta": time}, "time does not increase"),
        ({"s": time}, "recording 1 has no time column 't'"),
    ]:
        with pytest.raises(lacuna.LacunaError, match=words):
            lacuna.check(case.model, [data] if isinstance(data, int) else data)


def test_progress_is_told(case):
    told = []
    lacuna.diagnose(case.model, case.runs, progress=told.append)
    assert "smoothing the recordings" in told and told[-1] == "proving on held-out recordings"
    with pytest.raises(ZeroDivisionError):
        lacuna.diagnose(case.model, case.runs, progress=lambda doing: 1 / 0)


def test_progress_is_a_line_that_is_cleared(case, capsys):
    lacuna.diagnose(case.model, case.runs, only="coulomb_friction", progress=True)
    said = capsys.readouterr().err
    assert "smoothing the recordings" in said and said.endswith("\r\x1b[2K") and "\n" not in said
    lacuna.diagnose(case.model, case.runs, only="coulomb_friction")
    assert capsys.readouterr().err == ""


@pytest.fixture
def heard():
    """SIGINT is heard, as at a terminal: Python leaves it ignored where a shell runs the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_it_can_be_interrupted(case, heard):
    begun = time.monotonic()

    def interrupt(doing):
        if doing != "smoothing the recordings":
            os.kill(os.getpid(), signal.SIGINT)

    lacuna.diagnose(case.model, case.runs)
    whole = time.monotonic() - begun
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        lacuna.diagnose(case.model, case.runs, progress=interrupt)
    assert time.monotonic() - begun < whole


def test_the_lock_is_released(case):
    counted = []
    done = threading.Event()

    def count():
        while not done.wait(0.01):
            counted.append(1)

    counter = threading.Thread(target=count)
    counter.start()
    lacuna.diagnose(case.model, case.runs)
    done.set()
    counter.join()
    assert len(counted) > 10


def test_findings_pickle(found):
    assert pickle.loads(pickle.dumps(found.findings)) == found.findings
