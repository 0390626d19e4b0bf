"""The Tcl package of genomix against a run of a component with codels. It needs `tclsh`."""

import os
import shutil
import subprocess
import threading

import pytest

from hosted import ROOT, lay_out

TESTS = sorted((ROOT / "clients/tcl/tests").glob("*.tcl"))


@pytest.mark.skipif(shutil.which("tclsh") is None, reason="there is no `tclsh`")
@pytest.mark.parametrize("script", TESTS, ids=lambda script: script.stem)
def test_scripts_of_genomix_run_in_tcl(tmp_path, script):
    lay_out(tmp_path, "echo")
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)}
    command = [os.environ["DOTGEN"], "run", "echo/echo.gen", "--clock", "real", "--listen", "0"]
    command += ["--bounds", "none", "--until", "60s"]
    run = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    try:
        said = ""
        for line in run.stderr:
            said += line
            if "listening at 127" in line:
                break
        assert "listening at" in said, said
        threading.Thread(target=run.stderr.read, daemon=True).start()
        tcl = subprocess.run(["tclsh", script], env=environment, capture_output=True, text=True, timeout=60)
        assert tcl.returncode == 0, tcl.stdout + tcl.stderr
    finally:
        run.kill()
        run.wait()
