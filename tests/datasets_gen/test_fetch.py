import gzip
import io
import sys
import tarfile
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from lodbench.datasets_gen import catalogue, fetch, triangles
from lodbench.datasets_gen.ply import ply_file
from lodbench.datasets_gen.read import FileError, read_mesh

MESH = triangles.torus(9, 5)
DATA = ply_file(MESH)


class Silent(SimpleHTTPRequestHandler):
    def log_message(self, format, *args):
        pass


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A web site on this machine that offers two scans; what is fetched goes to a fresh folder."""
    pytest.importorskip("pooch")
    folder = tmp_path / "site"
    folder.mkdir()
    with tarfile.open(folder / "torus.tar.gz", "w:gz") as archive:
        entry = tarfile.TarInfo("recon/torus.ply")
        entry.size = len(DATA)
        archive.addfile(entry, io.BytesIO(DATA))
    (folder / "torus.ply.gz").write_bytes(gzip.compress(DATA))
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Silent, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    root = f"http://127.0.0.1:{server.server_port}"
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path / "data"))
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)

    def offer(name, file, member="", vertices=MESH.vertex_count, count=MESH.triangle_count):
        monkeypatch.setitem(
            fetch.SCANS, name, fetch.Scan(name, f"{root}/{file}", member, vertices, count)
        )

    yield offer
    server.shutdown()
    thread.join()
    server.server_close()


def left(tmp_path):
    return sorted(path.name for path in (tmp_path / "data" / "meshes").iterdir())


@pytest.mark.parametrize(
    "file, member", [("torus.tar.gz", "recon/torus.ply"), ("torus.ply.gz", "")]
)
def test_fetch_downloads_checks_and_keeps_a_scan(site, tmp_path, file, member):
    site("torus_scan", file, member)
    said = []
    path = fetch.fetch("torus_scan", said.append)
    assert path == tmp_path / "data" / "meshes" / "torus_scan.ply"
    assert read_mesh(path).triangle_count == MESH.triangle_count
    assert left(tmp_path) == ["torus_scan.ply"]
    assert "no checksum is published" in said[0]
    assert catalogue.load("torus_scan").surface.triangle_count == 90
    # there already: nothing is asked of the network
    site("torus_scan", "gone")
    assert catalogue.fetch(["torus_scan"]) == [path]


def test_fetch_refuses_a_scan_with_other_triangles(site, tmp_path):
    site("torus_scan", "torus.ply.gz", count=91)
    with pytest.raises(FileError, match="expected 45 vertices and 91 triangles, got"):
        fetch.fetch("torus_scan")
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    "file, member, vertices, message",
    [
        ("torus.ply.gz", "", 46, "expected 46 vertices and 90 triangles, got"),
        ("torus.tar.gz", "", 45, "not the scan"),
        ("torus.ply.gz", "recon/torus.ply", 45, "not the scan"),
        ("torus.tar.gz", "other.ply", 45, "not the scan"),
        ("gone.tar.gz", "x", 45, "cannot be downloaded"),
    ],
)
def test_fetch_refuses_what_is_not_the_scan_and_leaves_nothing(
    site, tmp_path, file, member, vertices, message
):
    site("torus_scan", file, member, vertices)
    with pytest.raises(FileError, match=message) as caught:
        fetch.fetch("torus_scan")
    assert "\n" not in str(caught.value)
    assert left(tmp_path) == []


def test_fetch_without_a_network_says_so(site, tmp_path, monkeypatch):
    # port 9 of this machine: nobody listens
    scan = fetch.Scan("bunny_69k", "http://127.0.0.1:9/bunny.tar.gz", "x", 1, 1)
    monkeypatch.setitem(fetch.SCANS, "bunny_69k", scan)
    with pytest.raises(FileError, match=r"bunny_69k: cannot be downloaded .* \(offline\?\)"):
        fetch.fetch("bunny_69k")
    assert left(tmp_path) == []


def test_fetch_without_pooch_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path))
    monkeypatch.setitem(sys.modules, "pooch", None)
    with pytest.raises(FileError, match=r"needs pooch: pip install 'lodbench\[datasets\]'"):
        fetch.fetch("bunny_69k")


def test_fetch_of_an_unknown_name_lists_the_known():
    with pytest.raises(
        FileError, match=r"expected one of bunny_69k armadillo_346k .* got 'teapot'"
    ):
        fetch.fetch("teapot")


def test_fetch_into_a_file_is_refused(tmp_path, monkeypatch):
    pytest.importorskip("pooch")
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path / "file"))
    with pytest.raises(FileError, match="cannot be made"):
        fetch.fetch("bunny_69k")


def test_published_counts_are_closed_surfaces_where_the_scan_is():
    # a closed surface of V vertices has at most 2 V - 4 triangles when its genus is 0
    for scan in fetch.SCANS.values():
        assert scan.url.startswith("https://graphics.stanford.edu/pub/3Dscanrep/")
        assert scan.triangles == pytest.approx(2 * scan.vertices, rel=0.04)
