import os
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from lodbench.datasets_gen.files import beside, is_part, replacing, write_file


def test_file_is_replaced_whole_and_leaves_nothing_beside_it(tmp_path):
    path = tmp_path / "a.txt"
    write_file(path, "one µ")
    write_file(path, b"two")
    assert path.read_bytes() == b"two"
    assert list(tmp_path.iterdir()) == [path]


def test_old_file_stays_where_writing_the_new_one_fails(tmp_path):
    path = tmp_path / "a.txt"
    write_file(path, "old")
    with pytest.raises(ZeroDivisionError), replacing(path) as stream:
        stream.write(b"new")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on a file's size")
def test_old_file_stays_where_there_is_no_room(tmp_path):
    path = tmp_path / "a.txt"
    write_file(path, "old")
    script = (
        "import resource, signal, sys\n"
        "from lodbench.datasets_gen.files import write_file\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n"
        "    write_file(sys.argv[1], bytes(5000))\n"
        "except OSError as error:\n"
        "    sys.exit(0 if error.filename == sys.argv[1] else 1)\n"
        "sys.exit(2)\n"
    )
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY
    done = subprocess.run([sys.executable, "-c", script, str(path)])
    assert done.returncode == 0
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_link_stays_one_and_its_file_keeps_its_mode(tmp_path):
    path, link = tmp_path / "a.txt", tmp_path / "link"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_file(link, "new")
    assert link.is_symlink()
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o640)


def test_what_a_killed_process_left_is_known_and_written_over(tmp_path):
    path = tmp_path / "a.txt"
    beside(path).write_text("half")
    assert is_part(beside(path))
    assert str(os.getpid()) in beside(path).name
    write_file(path, "whole")
    assert list(tmp_path.iterdir()) == [path]


def test_threads_that_write_one_file_leave_one_of_their_texts(tmp_path):
    path = tmp_path / "a.txt"
    texts = [bytes([65 + n]) * 200_000 for n in range(8)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda text: write_file(path, text), texts * 4))
    assert path.read_bytes() in texts
    assert list(tmp_path.iterdir()) == [path]
