from lodbench.harness.record.record import read_run
from lodbench.harness.report.provenance import again, environment
from tests.harness.made_run import make_run


def test_where_it_was_measured_is_in_words(tmp_path):
    blocks = dict(environment(read_run(make_run(tmp_path))))
    assert dict(blocks["Packages"]) == {"numpy": "2.0", "vtk": "absent"}
    assert dict(blocks["Machine"])["memory"] == "8.59 GB"
    limits = dict(blocks["Limits of the device, measured in this run"])
    assert limits["fill"] == "27 GB/s best, 26 GB/s median (kernel)"


def test_how_to_do_it_again_is_commands(tmp_path):
    run = read_run(make_run(tmp_path / "my run"))
    assert again(run).splitlines() == [
        "git checkout 0a1b2c3",
        "make setup",
        "lodbench reproduce clustering patterns --quick",
        "lodbench report 'my run'   # tables, figures and this file, from the records",
    ]
