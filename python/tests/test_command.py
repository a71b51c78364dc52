"""The command in the package."""

import subprocess
import sys

import drench


def command(*words, **options):
    return subprocess.run([sys.executable, "-m", "drench", *words], capture_output=True, text=True, **options)


def test_command_is_that_of_the_package(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command("--version").stdout == f"drench {drench.__version__}\n"
    said = command("info").stdout
    assert drench.info()["commit"] in said and drench.info()["backend"] in said
    process = command("run", str(drench.scenes / "water_on_cloth.yaml"), "--steps", "2", "-o", "out", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "2 steps to t = " in process.stdout
    assert command("report", "out", cwd=tmp_path).returncode == 0
    assert drench.write_report("out", "page.html").read_text() == (tmp_path / "out/report.html").read_text()


def test_command_reports_errors(tmp_path):
    process = command("run", "none.yaml", cwd=tmp_path)
    assert process.returncode == 2 and process.stderr.startswith("none.yaml: ") and process.stderr.count("\n") == 1
    process = command("export", "none", "--to", "usd", cwd=tmp_path)
    assert process.returncode == 2 and process.stderr.count("\n") == 1
