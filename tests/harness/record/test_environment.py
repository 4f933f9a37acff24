import subprocess

from lodbench.harness.record import environment


def test_commit_is_unknown_without_git(monkeypatch):
    def absent(*arguments, **options):
        raise FileNotFoundError("git")

    monkeypatch.setattr(subprocess, "run", absent)
    assert environment.commit() == ("unknown", False)


def test_commit_of_another_projects_checkout_is_not_ours(monkeypatch, tmp_path):
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    installed = tmp_path / "lib/harness/environment.py"
    installed.parent.mkdir(parents=True)
    monkeypatch.setattr(environment, "__file__", str(installed))
    assert environment.commit() == ("unknown", False)


def test_versions_of_absent_packages_are_none(monkeypatch):
    monkeypatch.setattr(environment, "PACKAGES", ("numpy", "no-such-package"))
    found = environment.package_versions()
    assert found["numpy"]
    assert found["no-such-package"] is None


def test_only_variables_that_matter_are_kept(monkeypatch):
    monkeypatch.setenv("POCL_MAX_PTHREAD_COUNT", "2")
    monkeypatch.setenv("SECRET_TOKEN", "x")
    assert environment.variables()["POCL_MAX_PTHREAD_COUNT"] == "2"
    assert "SECRET_TOKEN" not in environment.variables()


def test_environment_keeps_no_paths_of_the_machine(monkeypatch):
    monkeypatch.setenv("LODBENCH_DATA", "/somebody/models")
    monkeypatch.setenv("POCL_AFFINITY", "1")
    found = environment.variables()
    assert found["LODBENCH_DATA"] == "models"
    assert found["POCL_AFFINITY"] == "1"
