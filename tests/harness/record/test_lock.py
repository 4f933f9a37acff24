import os

import psutil
import pytest

from lodbench.harness.record import lock
from lodbench.harness.record.lock import OWNER, Busy, Lock


@pytest.fixture(params=["locked files", "a note"])
def way(request, monkeypatch):
    """Systems that lock files, and those that do not."""
    if request.param == "a note":
        monkeypatch.setattr(lock, "fcntl", None)
    elif lock.fcntl is None:
        pytest.skip("this system locks no files")
    return request.param


def test_folder_has_one_writer_until_it_lets_go(way, tmp_path):
    with (tmp_path / "rows").open("ab") as first, (tmp_path / "rows").open("ab") as second:
        held = Lock(first, tmp_path)
        with pytest.raises(
            Busy, match="out: expected a folder that no other run is writing"
        ) as error:
            Lock(second, tmp_path)
        assert str(tmp_path) in str(error.value)
        assert f"process {os.getpid()}" in str(error.value) or way == "locked files"
        held.release()
        Lock(second, tmp_path).release()
    assert not (tmp_path / OWNER).exists()


@pytest.mark.parametrize("note", ["", "no number", "{pid} 1.0", "99999999 1.0", "{pid}", "1 2 3"])
def test_note_of_a_process_that_is_gone_holds_nobody_up(monkeypatch, tmp_path, note):
    monkeypatch.setattr(lock, "fcntl", None)
    (tmp_path / OWNER).write_text(note.format(pid=os.getpid()))
    with (tmp_path / "rows").open("ab") as file:
        Lock(file, tmp_path)
        number, started = (tmp_path / OWNER).read_text().split()
    assert int(number) == os.getpid()
    assert float(started) == psutil.Process().create_time()
