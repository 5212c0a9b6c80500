"""One work on many items: here, and on workers that are processes of their own."""

from __future__ import annotations

import sys

import pytest

from tests.support import works
from toolpace.common import cluster
from toolpace.common.cluster import dask_pool, open_pool
from toolpace.common.cluster.pool import ThisProcess
from toolpace.common.errors import ClusterError, UsageError


@pytest.fixture(scope="module")
def two():
    pytest.importorskip("distributed")
    with open_pool(2, memory="2GB") as pool:
        yield pool


@pytest.fixture(params=["here", "two workers"])
def pool(request):
    return request.getfixturevalue("two") if request.param == "two workers" else ThisProcess()


def test_every_item_has_one_outcome(pool):
    found = list(pool.each(works.added, 100, range(30)))
    assert sorted(each.number for each in found) == list(range(30))
    good = {each.item: each.value for each in found if not each.error}
    assert good == {item: 100 + item for item in range(30) if item not in (7, 9)}
    wrong = {each.item: each.error for each in found if each.error}
    assert wrong[7] == "a fault in toolpace itself, ValueError: seven in two lines"
    assert wrong[9].startswith("out of memory; ") and set(wrong) == {7, 9}


def test_items_are_drawn_when_there_is_room(pool):
    drawn = []

    def items():
        for k in range(100):
            drawn.append(k)
            yield k

    outcomes = pool.each(works.added, 0, items())
    for done in range(1, 20):
        next(outcomes)
        assert len(drawn) <= done + 5
    outcomes.close()
    assert len(drawn) < 30


def test_what_no_worker_holds_is_not_begun(pool):
    found = list(pool.each(works.added, 0, [1, 2], memory=lambda item: 1e15 if item == 2 else 0.0))
    errors = {each.item: each.error for each in found}
    assert errors[1] == "" and errors[2].startswith("takes about 1e+06 GB of memory")


def test_both_workers_work_and_one_that_is_to_be_avoided_does_not(two):
    everybody = {each.worker for each in two.each(works.slow, 0.05, range(12))}
    assert len(everybody) == 2
    spared = sorted(everybody)[0]
    assert {each.worker for each in two.each(works.slow, 0.05, range(12), avoid={spared})} == everybody - {spared}


@pytest.mark.sweep
def test_whoever_kills_its_worker_is_told_so_and_harms_nobody(two, tmp_path):
    found = {each.item: each for each in two.each(works.killing, str(tmp_path / "first"), range(20))}
    assert sorted(found) == list(range(20))
    assert {item for item, each in found.items() if each.error} == {5}
    assert "died each time" in found[5].error and "memory limit is 2 GB" in found[5].error
    assert found[6].value == 6


@pytest.mark.sweep
def test_what_all_have_in_common_outlives_the_workers_that_had_it(two, tmp_path):
    """More than goes with each item: both workers die of item 6 and 5, and others do the rest."""
    common = (str(tmp_path / "first"), bytes(100_000))
    found = {each.item: each for each in two.each(works.killing_with_much, common, range(12))}
    assert {item: each.value for item, each in found.items() if not each.error} == {
        item: 100_000 for item in range(12) if item != 5
    }
    assert "died each time" in found[5].error and len(found) == 12


def test_the_scheduler_keeps_no_note_of_tasks_that_are_done(two, monkeypatch):
    """Else it grows with every task, for as long as it runs: see `benchmarks.cluster --only small`."""
    monkeypatch.setattr(dask_pool, "OFTEN", 20)
    assert len(list(two.each(works.added, 0, range(100)))) == 100
    names, kinds = two._client.run_on_scheduler(works.scheduler_notes)
    assert 0 < names <= 40 and 0 < kinds <= 40


def test_a_client_of_ones_own_stays_open(two):
    client = two._client
    client.wait_for_workers(2, timeout=60)
    with open_pool(client) as pool:
        assert pool.where.startswith("2 workers of tcp://")
        assert [each.value for each in pool.each(works.added, 1, [1])] == [2]
    assert client.status == "running"


@pytest.mark.sweep
def test_no_scheduler_there(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    message = r"--cluster tcp://127.0.0.1:9: no scheduler answers .* `dask scheduler`"
    with pytest.raises(ClusterError, match=message), open_pool("tcp://127.0.0.1:9"):
        pass


@pytest.mark.parametrize("memory", ["much", "4 parsecs"])
def test_memory_that_is_none(memory):
    pytest.importorskip("distributed")
    with pytest.raises(UsageError, match=f"--memory {memory}: .*like 4GB"), open_pool(1, memory):
        pass


def test_without_dask(monkeypatch):
    monkeypatch.setattr(cluster, "installed", lambda: False)
    with open_pool() as pool:
        assert pool.where.startswith("this process") and "pip install 'toolpace[cluster]'" in pool.note
    for where in (2, "tcp://127.0.0.1:9"):
        with pytest.raises(UsageError, match=r"pip install 'toolpace\[cluster\]'"), open_pool(where):
            pass


def test_the_room_imports_no_dask():
    import subprocess

    code = "import sys, toolpace.common.cluster, toolpace.jobs.batch; print({'dask', 'distributed'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "set()", done.stderr
