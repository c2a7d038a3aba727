"""Tasks in processes of this machine: one that ends its process or is too slow stops no other."""

import json
import signal
import sys

import pytest
from tasks import of_numbers, running, work

from leadthrough import tasks
from leadthrough.errors import InvalidInput
from leadthrough.tasks import Store, Task, code


def test_processes_make_the_rows_of_a_serial_run(tmp_path):
    todo = work.draws_of(6, tmp_path / "log")
    runs = {name: Store(tmp_path / name) for name in ("serial", "processes")}
    assert len(list(tasks.run(todo, runs["serial"]))) == 6
    hosts = {each.host for each in tasks.run(todo, runs["processes"], on="local:2")}
    assert len(hosts) == 2
    assert work.rows_of(todo, runs["serial"]) == work.rows_of(todo, runs["processes"])


def test_what_is_stored_is_not_done_again(tmp_path):
    store = Store(tmp_path / "store")
    list(tasks.run(work.draws_of(3, tmp_path / "log"), store))
    again = list(tasks.run(work.draws_of(5, tmp_path / "log"), store))
    assert [each.known for each in again] == [True, True, True, False, False]
    assert (tmp_path / "log").read_text().split() == ["0", "1", "2", "3", "4"]


def test_each_bad_task_is_one_failure_and_the_others_are_done(tmp_path):
    log = tmp_path / "log"
    todo = [
        Task(work.ends, {"code": 7}),
        Task(work.ends, {"code": -signal.SIGSEGV}),
        Task(work.lasts, {"seconds": 60.0}),
        Task(work.exits, {}),
        Task(work.is_killed_once, {"log": str(tmp_path / "killed")}),
        *work.draws_of(3, log),
    ]
    store = Store(tmp_path / "store")
    outcomes = sorted(tasks.run(todo, store, on="local:2", timeout=2.0), key=lambda o: o.index)
    failures = [each.failure for each in outcomes[:4]]
    assert [failure["error"] for failure in failures] == [
        "WorkerKilled",
        "WorkerKilled",
        "Timeout",
        "SystemExit",
    ]
    assert "exit code 7 in each of 3 attempts" in failures[0]["message"]
    assert "SIGSEGV" in failures[1]["message"]
    assert "longer than 2 s" in failures[2]["message"]
    assert "raise SystemExit(3)" in failures[3]["traceback"]
    assert [each.failure for each in outcomes[4:]] == [None] * 4
    assert outcomes[4].attempts == 2
    # The attempts of a task that failed are counted over all runs.
    assert [each.attempts for each in tasks.run(todo[:1], store, on="local:1")] == [6]


def test_a_file_is_known_by_its_content(tmp_path):
    store = Store(tmp_path / "store")
    files = [tmp_path / name for name in ("one.csv", "same.csv", "other.csv")]
    for file, text in zip(files, ("x", "x", "y"), strict=True):
        file.write_text(text)
    todo = [Task(work.reads, {}, {"recording": file}) for file in files]
    assert todo[0].key == todo[1].key != todo[2].key
    assert [each.known for each in tasks.run(todo, store)] == [False, True, False]
    assert work.rows_of(todo, store)[1:] == [
        [{"text": "x", "suffix": ".csv"}],
        [{"text": "y", "suffix": ".csv"}],
    ]
    with pytest.raises(InvalidInput, match=r"none\.csv"):
        list(tasks.run([Task(work.reads, {}, {"recording": tmp_path / "none.csv"})], store))


def test_a_function_of_the_prompt_is_known_by_its_own_code(tmp_path):
    written = []
    for text in ("1", "1", "2"):
        names = {}
        exec(f"def made(): return [{{'number': {text}}}]", names)
        task = Task(names["made"], {})
        (outcome,) = tasks.run([task], Store(tmp_path))
        written.append((outcome.known, Store(tmp_path).rows(task.key)[0]["number"]))
    assert written == [(False, 1), (True, 1), (False, 2)]


def test_a_function_that_no_process_can_import_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="import by its name"):
        list(tasks.run([Task(lambda: [], {})], Store(tmp_path), on="local:1"))


def test_ctrl_c_writes_the_results_and_the_next_run_goes_on(tmp_path):
    out = tmp_path / "out"
    client = running.started(out, "local:2")
    client.send_signal(signal.SIGINT)
    assert client.wait(20) == -signal.SIGINT
    document = json.loads((out / "results.json").read_text())
    done = len(document["rows"])
    assert document["unfinished"] == of_numbers.COUNT - done
    listed = len(json.loads((out / "manifest.json").read_text()))
    assert listed <= done <= listed + 2
    ran = (out / "log").read_text().split()
    assert done <= len(ran) <= done + 4 < of_numbers.COUNT
    # Rows that were stored as the client stopped are known too.
    store = Store(out / "cache")
    known = sum(store.report(task.key) is not None for task in of_numbers.slow(out))
    assert max(3, done) <= known <= done + 2


FILES = {
    "paper/__init__.py": "",
    "paper/work.py": "from paper import used\ndef f():\n    from . import late\nimport beside\n",
    "paper/used.py": "import numpy\n",
    "paper/late.py": "TYPE_CHECKING = False\nif TYPE_CHECKING:\n    import paper.typed\n",
    "paper/typed.py": "",
    "paper/unused.py": "",
    "beside.py": "",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    (tmp_path / "paper").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    return tmp_path


def digest():
    for cached in (code.digest, code.sources, code._file_of, code._stub, code._imports):
        cached.cache_clear()
    return code.digest("paper.work")


@pytest.mark.parametrize("name", FILES)
def test_only_an_edit_of_what_is_imported_changes_the_digest(package, name):
    before = digest()
    (package / name).write_text(FILES[name] + "# edited\n")
    assert (digest() != before) == (name not in {"paper/unused.py", "paper/typed.py"})


def test_names_of_lazy_packages_lead_to_their_modules(package):
    (package / "paper" / "work.py").write_text("import leadthrough as lt\nlt.retime(lt.DMP)\n")
    digest()
    found = code.sources("paper.work")
    assert {"leadthrough.timing.retiming", "leadthrough.models.dmp.discrete"} <= set(found)
    assert "leadthrough.models.promp.model" not in found
    assert found["leadthrough._core"].suffix == ".so"


def test_what_only_displays_has_no_part_in_the_rows():
    found = set(code.sources("leadthrough_studies.trajectories.study"))
    assert {"leadthrough.timing.retiming", "robots/ur3/ur3.urdf"} <= found
    parts = {name.split(".")[1] for name in found if name.count(".")}
    assert not parts & {"cli", "drawing", "show", "tasks", "preprocess", "planning"}
    assert "leadthrough.models.promp.model" not in found
    assert "leadthrough_studies.trajectories.report" not in found
