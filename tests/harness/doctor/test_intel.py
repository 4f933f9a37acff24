from types import SimpleNamespace

import pytest

from lodbench.harness.doctor import intel


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """Intel's package in a folder of its own, and pyopencl's folder of drivers; both to be changed."""
    library = tmp_path / "lib" / intel.LIBRARY
    library.parent.mkdir()
    library.touch()
    (library.parent / intel.NEEDED).touch()
    drivers = tmp_path / "pyopencl" / ".libs"
    drivers.mkdir(parents=True)
    file = SimpleNamespace(name=intel.LIBRARY, locate=lambda: library)
    monkeypatch.setattr(intel.importlib.metadata, "files", lambda name: [file])
    monkeypatch.setattr(
        intel.importlib.util, "find_spec",
        lambda name: SimpleNamespace(origin=str(drivers.parent / "__init__.py")),
    )  # fmt: skip
    monkeypatch.setenv("OCL_ICD_VENDORS", str(tmp_path / "none"))
    return library, drivers


def test_nothing_is_said_without_the_package(monkeypatch):
    def missing(name):
        raise intel.importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(intel.importlib.metadata, "files", missing)
    assert list(intel.driver_file()) == []


def test_driver_file_is_written_once(installed):
    library, drivers = installed
    (finding,) = intel.driver_file()
    assert finding.status == "ok" and "was written" in finding.detail
    assert (drivers / intel.NAME).read_text() == f"{library}\n"
    (again,) = intel.driver_file()
    assert again.status == "ok" and "was written" not in again.detail


def test_package_that_it_needs_is_named(installed):
    library, drivers = installed
    (library.parent / intel.NEEDED).unlink()
    (finding,) = intel.driver_file()
    assert finding.status == "warn" and finding.mend.endswith("intel-cmplr-lib-rt")
    assert not (drivers / intel.NAME).exists()


def test_folder_that_cannot_be_written_ends_in_a_line_that_does_without(installed):
    library, drivers = installed
    drivers.rmdir()
    (finding,) = intel.driver_file()
    assert finding.status == "warn" and f"echo {library}" in finding.mend
