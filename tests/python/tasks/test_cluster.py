"""A Dask cluster of three workers in processes of their own, which tests kill one by one."""

import json
import signal
import time

import pytest
from distributed import CancelledError, Client
from distributed.comm import CommClosedError
from tasks import of_numbers, running, work
from typer.testing import CliRunner

from leadthrough import cli, tasks
from leadthrough.errors import CodeMismatch, SchedulerUnreachable
from leadthrough.tasks import Store, Task
from leadthrough_studies import catalogue

WORKERS = 3


class RunningCluster:
    """A scheduler and its workers."""

    def __init__(self, folder):
        self.file = folder / "scheduler.json"
        self.log = folder / "messages"
        common = ("--scheduler-file", self.file, "--no-dashboard")
        self.scheduler = running.program(
            "distributed.cli.dask_scheduler", *common, "--host", "127.0.0.1", "--port", "0",
            log=self.log,
        )  # fmt: skip
        alone = ("--no-nanny", "--nthreads", "1", "--local-directory", folder)
        worker = ("distributed.cli.dask_worker", *common, *alone)
        self.workers = [
            running.program(*worker, "--name", name, log=self.log) for name in range(WORKERS)
        ]
        running.wait(self.file.exists, self.scheduler, self.log)
        self.client = Client(scheduler_file=str(self.file), set_as_default=False)
        self.client.wait_for_workers(WORKERS, timeout=60)

    def close(self):
        self.client.close()
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    found = RunningCluster(tmp_path_factory.mktemp("cluster"))
    yield found
    found.close()


def run(todo, store, cluster, **options):
    found = tasks.run(todo, store, on=str(cluster.file), **options)
    return sorted(found, key=lambda each: each.index)


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """Rows by seed of a serial run."""
    folder = tmp_path_factory.mktemp("serial")
    todo = work.draws_of(of_numbers.COUNT, folder / "log")
    list(tasks.run(todo, Store(folder)))
    return work.rows_of(todo, Store(folder))


def test_rows_are_those_of_a_serial_run_and_several_workers_make_them(cluster, tmp_path, serial):
    todo = work.draws_of(12, tmp_path / "log", 0.05)
    outcomes = run(todo, Store(tmp_path), cluster)
    assert work.rows_of(todo, Store(tmp_path)) == serial[:12]
    assert len({each.host for each in outcomes}) >= 2


def test_a_file_comes_to_the_workers_by_its_content(cluster, tmp_path):
    files = [tmp_path / "one.csv", tmp_path / "same.csv"]
    for file in files:
        file.write_text("shown")
    todo = [
        Task(work.reads, {"times": times}, {"recording": file})
        for times in range(1, 4)
        for file in files
    ]
    run(todo, Store(tmp_path / "store"), cluster)
    assert work.rows_of(todo[::2], Store(tmp_path / "store")) == [
        [{"text": times * "shown", "suffix": ".csv"}] for times in range(1, 4)
    ]
    kept = list(cluster.file.parent.rglob("leadthrough/*.csv"))
    assert 1 <= len(kept) <= WORKERS


def test_rows_come_back_where_the_workers_do_not_see_the_store(cluster, tmp_path, monkeypatch):
    store = Store(tmp_path)
    monkeypatch.setattr(Store, "identity", lambda _: "elsewhere")
    todo = [Task(work.reads, {}, {"recording": tmp_path / "a.txt"})]
    (tmp_path / "a.txt").write_text("shown")
    list(tasks.run(todo, store, on=cluster.client.scheduler.address))
    assert work.rows_of(todo, store) == [[{"text": "shown", "suffix": ".txt"}]]


def failing_experiment(cluster, out, *words):
    """Output of an experiment with failures, and its results."""
    words = ["experiment", "ur3", "--out", str(out), "--on", str(cluster.file), *words]
    result = CliRunner().invoke(cli.app, words)
    assert result.exit_code == 1, result.output
    return result, json.loads((out / "results.json").read_text())


def test_a_task_that_ends_its_process_is_one_failure_of_the_study(cluster, tmp_path, monkeypatch):
    todo = [
        *work.draws_of(3, tmp_path / "log"),
        Task(work.ends, {"code": 5}),
        Task(work.lasts, {"seconds": 60.0}),
    ]
    monkeypatch.setitem(catalogue.STUDIES, "ur3", of_numbers.study_of(todo))
    _, document = failing_experiment(cluster, tmp_path, "--task-timeout", "1")
    assert [failure["error"] for failure in document["failures"]] == ["WorkerKilled", "Timeout"]
    assert [row["seed"] for row in document["rows"]] == [0, 1, 2]


def test_a_worker_with_other_code_is_refused(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr("leadthrough.tasks.code.digest", lambda _: "edited")
    with pytest.raises(CodeMismatch, match="other code"):
        run(work.draws_of(2, tmp_path / "log"), Store(tmp_path), cluster)
    assert not (tmp_path / "log").exists()


def test_a_killed_client_goes_on_with_what_is_missing(cluster, tmp_path, serial):
    out = tmp_path / "out"
    client = running.started(out, cluster.file)
    client.kill()
    client.wait()
    todo = of_numbers.slow(out)
    store = Store(out / "cache")
    known = until_quiet(out)
    assert 3 <= known < of_numbers.COUNT
    assert sum(each.known for each in run(todo, store, cluster)) == known
    assert len((out / "log").read_text().split()) == of_numbers.COUNT
    assert work.rows_of(todo, store) == serial


def until_quiet(out):
    """The number of finished tasks, once those that workers had begun are finished too."""
    before, quiet = None, 0
    while True:
        begun = len((out / "log").read_text().split())
        finished = len(list(out.glob("cache/??/[!.]*.json")))
        quiet = quiet + 1 if (begun, finished) == before and begun == finished else 0
        if quiet == 3:
            return finished
        before = begun, finished
        time.sleep(0.3)


def test_a_killed_worker_changes_no_row(cluster, tmp_path, serial):
    todo = work.draws_of(of_numbers.COUNT, tmp_path / "log", 0.1)
    store = Store(tmp_path)
    for number, each in enumerate(tasks.run(todo, store, on=str(cluster.file))):
        assert each.failure is None
        if number == 2:
            cluster.workers[0].send_signal(signal.SIGKILL)
    assert work.rows_of(todo, store) == serial


@pytest.mark.parametrize(
    ("method", "error"),
    [
        ("Future.result", CancelledError()),  # lost between its end and its rows' arrival
        ("Client.nthreads", TimeoutError("timed out")),
        ("Client.run", CommClosedError("in <TCP (closed)>: Stream is closed")),
        ("Client.submit", RuntimeError("ConnectionPool closing.")),
    ],
)
def test_a_broken_connection_is_a_lost_cluster(method, error, cluster, tmp_path, monkeypatch):
    """The scheduler may end at any moment."""

    def broken(*_, **__):
        raise error

    monkeypatch.setattr(f"distributed.{method}", broken)
    (tmp_path / "a.txt").write_text("shown")
    todo = [Task(work.reads, {}, {"recording": tmp_path / "a.txt"})]
    with pytest.raises(SchedulerUnreachable, match="run the same command again"):
        run(todo, Store(tmp_path), cluster)


def test_without_its_scheduler_a_study_keeps_what_is_finished(
    cluster, tmp_path, monkeypatch, caplog
):
    todo = Ending(work.draws_of(of_numbers.COUNT, tmp_path / "log", 0.02), cluster.scheduler)
    monkeypatch.setitem(catalogue.STUDIES, "ur3", of_numbers.study_of(todo))
    result, document = failing_experiment(cluster, tmp_path)
    assert "scheduler" in result.stderr and "Traceback" not in result.stderr
    assert not [each for each in caplog.records if each.exc_info]  # Dask prints them
    done = of_numbers.COUNT - document["unfinished"]
    assert 8 <= len(document["rows"]) == done < of_numbers.COUNT
    assert len(list(tmp_path.glob("cache/??/[!.]*.json"))) == done


class Ending(list):
    """Tasks of which the 44th is followed by the end of the scheduler."""

    def __init__(self, todo, scheduler):
        super().__init__(todo)
        self.scheduler = scheduler

    def __iter__(self):
        for number, task in enumerate(super().__iter__()):
            if number == 44 and self.scheduler.poll() is None:
                self.scheduler.kill()
                self.scheduler.wait()
            yield task
