"""Workers of a dask scheduler, in processes of their own; one is killed in the middle."""

import os
import signal
import warnings

import pytest
from tests.sweeps import small
from tests.sweeps.test_store import chunks_of

import stickslip as ss
from stickslip.errors import TilesFailed, WorkersLost

distributed = pytest.importorskip("distributed")


def process_id():
    return os.getpid()


@pytest.fixture(scope="module")
def cluster():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the scheduler's dashboard and its sockets
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster:
            yield cluster


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_killed_worker_changes_nothing(cluster, tmp_path):
    small.run_slowly(tmp_path / "here")
    killed = []

    def kill_one(progress):
        if progress.done > 20 and not killed:
            workers = client.run(process_id)
            killed.append(next(iter(workers.values())))
            os.kill(killed[0], signal.SIGKILL)

    with distributed.Client(cluster) as client:
        small.run_slowly(tmp_path / "there", client=client, threads=None, progress=kill_one)
        assert killed
    assert chunks_of(tmp_path / "there") == chunks_of(tmp_path / "here")
    assert ss.open_sweep(tmp_path / "there").attrs["done"] == 20


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_map_of_one_s_own_travels_to_workers(cluster, tmp_path):
    f = ss.PiecewiseMap(small.logistic, (0, 1), parameters={"r": 3.0})
    wanted = [ss.observables.Attractor(transient=100, n=100)]
    with distributed.Client(cluster) as client:
        found = ss.sweep(f, {"r": [2.5, 3.3]}, wanted, store=tmp_path / "x.zip", client=client)
        assert found.period.values.tolist() == [1, 2]
        with pytest.raises(TilesFailed, match=r"4 chunks of .*ArithmeticError: on purpose"):
            small.run(
                tmp_path / "y",
                observables=[small.fails_somewhere],
                client=client,
                threads=None,
            )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("lose", ["close", "shutdown"])
def test_a_scheduler_or_client_that_is_lost_is_told_with_what_to_do(tmp_path, lose):
    def at_half(progress):
        if progress.done > 40 and not lost:
            lost.append(progress.done)
            getattr(client, lose)()

    lost = []
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
        pytest.raises(WorkersLost, match=r"scheduler or its client is lost .*--resume"),
    ):
        small.run_slowly(tmp_path / "x", client=client, threads=None, progress=at_half)
    assert 0 < ss.open_sweep(tmp_path / "x").attrs["done"] < 20
    small.run_slowly(tmp_path / "x")
    small.run_slowly(tmp_path / "whole")
    assert chunks_of(tmp_path / "x") == chunks_of(tmp_path / "whole")


def test_a_scheduler_without_workers_is_refused(tmp_path):
    class Client:
        status = "running"

        def ncores(self):
            return {}

    with pytest.raises(ValueError, match="client: its scheduler has no workers"):
        small.run(tmp_path / "x", client=Client(), threads=None)
