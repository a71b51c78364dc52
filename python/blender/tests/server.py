"""An ssh server of the current user on a port of this computer, with keys of its own, and a stand-in for ssh.

Both put a program `ssh` first in PATH, so that the user's own keys and configuration are neither read nor changed."""

import getpass
import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

SSH, SSHD = shutil.which("ssh"), shutil.which("sshd", path=os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin")
MISSING = "needs ssh and sshd: package openssh-server" if not (SSH and SSHD) else ""
ALIAS = "drench-test"


def put_first(case, folder, script):
    """A shell script as program `ssh`, until the test has ended."""
    folder.mkdir(exist_ok=True)
    (folder / "ssh").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "ssh").chmod(0o755)
    before = os.environ["PATH"]
    os.environ["PATH"] = f"{folder}{os.pathsep}{before}"
    case.addCleanup(os.environ.update, PATH=before)


class Server:
    """The home folder of its sessions is `home`."""

    def __init__(self, folder):
        self.folder, self.home = folder, folder / "home"
        self.home.mkdir(parents=True)
        for key in ("host", "user", "other"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / key)], check=True)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        shutil.copy(folder / "user.pub", folder / "authorized")
        (folder / "session").write_text(f"#!/bin/sh\necho Welcome\nHOME={self.home}\nexport HOME\n"
                                        'exec /bin/sh -c "$SSH_ORIGINAL_COMMAND"\n')
        (folder / "session").chmod(0o755)
        (folder / "sshd_config").write_text(
            f"Port {self.port}\nListenAddress 127.0.0.1\nHostKey {folder}/host\n"
            f"AuthorizedKeysFile {folder}/authorized\nPidFile none\nUsePAM no\nStrictModes no\nPasswordAuthentication no\nForceCommand {folder}/session\n")
        known = f"[127.0.0.1]:{self.port} " + (folder / "host.pub").read_text()
        (folder / "known").write_text(known)
        self.write_config(f"Host {ALIAS}\n  Port {self.port}\n  IdentityFile {folder}/user\n")

    def write_config(self, text):
        (self.folder / "config").write_text(
            text + f"Host *\n  HostName 127.0.0.1\n  User {getpass.getuser()}\n"
            f"  UserKnownHostsFile {self.folder}/known\n  GlobalKnownHostsFile /dev/null\n  IdentitiesOnly yes\n  IdentityAgent none\n")

    def use(self, case):
        put_first(case, self.folder / "bin", f'exec {SSH} -F {self.folder}/config "$@"')

    def start(self):
        if os.geteuid() == 0:
            Path("/run/sshd").mkdir(exist_ok=True)  # sshd refuses to start without it
        with open(self.folder / "log", "ab") as log:
            self.process = subprocess.Popen([SSHD, "-D", "-e", "-f", str(self.folder / "sshd_config")], stderr=log,
                                            start_new_session=True)
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline and self.process.poll() is None:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.05)
        raise RuntimeError("sshd did not start: " + (self.folder / "log").read_text())

    def stop(self):
        """Ends the server and its connections, but not what they started."""
        if self.process.poll() is None:
            for pid in sessions_of(self.process.pid):
                os.kill(pid, 9)
            self.process.kill()
        self.process.wait()


def sessions_of(parent):
    """Process ids of the connections of a server, which are its children and theirs of the same name."""
    found = []
    for pid in Path("/proc").glob("[0-9]*"):
        try:
            name, fields = (pid / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
        except OSError:
            continue
        if name.startswith("sshd") and int(fields.split()[1]) == parent:
            found += [int(pid.name), *sessions_of(int(pid.name))]
    return found


if __name__ == "__main__":
    sys.exit("server.py is part of the tests: start run.py")
